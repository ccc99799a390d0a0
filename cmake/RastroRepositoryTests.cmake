# Tests of the repository itself: layers, sizes, generated pages, installation.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME repository.layers COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/check_layers.py")
add_test(NAME repository.code_size
  COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/code_size_test.py")
add_test(NAME repository.tidy
  COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/tidy_test.py")
add_test(NAME repository.layers_checker
  COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/check_layers_test.py")
add_test(NAME repository.docs_checker
  COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/check_docs_test.py")

# A project outside of rastro, against an installation. Sanitized libraries would need a sanitized consumer.
if(NOT RASTRO_SANITIZERS)
  add_test(NAME repository.consumer
    COMMAND ${CMAKE_COMMAND} "-DBUILD=${PROJECT_BINARY_DIR}" "-DSOURCE=${PROJECT_SOURCE_DIR}/tests/consumer"
            "-DWORK=${PROJECT_BINARY_DIR}/consumer" "-DCOMPILER=${CMAKE_CXX_COMPILER}"
            -P "${PROJECT_SOURCE_DIR}/tests/consumer/run.cmake")
  set_tests_properties(repository.consumer PROPERTIES TIMEOUT 120)
endif()

# Every command on generated broken inputs; by hand before a release: --count 5000. A sanitizer is too slow for its limits of time.
if(RASTRO_BUILD_PROGRAM AND NOT RASTRO_SANITIZERS)
  add_test(NAME repository.broken_inputs
    COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/tests/broken_inputs.py" "$<TARGET_FILE:rastro_program>"
            "${PROJECT_BINARY_DIR}/broken_inputs" --count 48 --jobs 2)
  set_tests_properties(repository.broken_inputs PROPERTIES TIMEOUT 300)
endif()

# The reference page of the options is generated: it must say what the program says.
if(RASTRO_BUILD_PROGRAM)
  add_test(NAME repository.option_pages
    COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/option_pages.py" --check "$<TARGET_FILE:rastro_program>")
endif()

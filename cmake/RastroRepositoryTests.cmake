# Tests of the repository itself: layers, generated pages, installation.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME repository.layers COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/check_layers.py")
add_test(NAME repository.layers_checker
  COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/check_layers_test.py")

# rastro_module(NAME [PUBLIC lib...] [PRIVATE lib...]): the folder src/rastro/NAME as one internal library.
# Every *.cpp below the folder is a source (main.cpp apart), every *_test.cpp a test, every *_testing.cpp a help to tests; what it may use is read from layers.txt,
# and configuring stops when a line of that table is not sound. All modules together make librastro.
define_property(GLOBAL PROPERTY RASTRO_MODULES BRIEF_DOCS "modules in build order" FULL_DOCS "modules in build order")

# Reads layers.txt once: RASTRO_LAYER_<folder> and RASTRO_USES_<folder> for every folder named there.
function(rastro_read_layers)
  file(STRINGS "${PROJECT_SOURCE_DIR}/layers.txt" lines REGEX "^[0-9]")
  set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/layers.txt")
  foreach(line IN LISTS lines)
    if(NOT line MATCHES "^([0-9]+) ([a-z_, ]+):(.*)$")
      message(FATAL_ERROR "layers.txt: cannot read '${line}'; write 'LAYER FOLDER[, FOLDER]: FOLDER ...'")
    endif()
    set(layer "${CMAKE_MATCH_1}")
    # The next REGEX overwrites CMAKE_MATCH_3, so it is read first.
    string(STRIP "${CMAKE_MATCH_3}" uses)
    string(REGEX REPLACE "[, ]+" ";" folders "${CMAKE_MATCH_2}")
    string(REGEX REPLACE " +" ";" uses "${uses}")
    foreach(folder IN LISTS folders)
      set(RASTRO_LAYER_${folder} ${layer})
      set(RASTRO_LAYER_${folder} ${layer} PARENT_SCOPE)
      set(RASTRO_USES_${folder} "${uses}" PARENT_SCOPE)
      foreach(used IN LISTS uses)
        if(NOT DEFINED RASTRO_LAYER_${used} OR NOT RASTRO_LAYER_${used} LESS layer)
          message(FATAL_ERROR "layers.txt: '${folder}' (layer ${layer}) uses '${used}', which is not on a lower layer")
        endif()
      endforeach()
    endforeach()
  endforeach()
endfunction()
rastro_read_layers()

function(rastro_module name)
  cmake_parse_arguments(arg "" "" "PUBLIC;PRIVATE" ${ARGN})
  if(NOT DEFINED RASTRO_LAYER_${name})
    message(FATAL_ERROR "module '${name}' has no line in layers.txt")
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  list(FILTER sources EXCLUDE REGEX "(_test\\.cpp|_testing\\.cpp|/main\\.cpp)$")
  if(NOT sources)  # a module of headers alone still needs something to archive
    file(CONFIGURE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/headers_only.cpp" CONTENT "")
    set(sources "${CMAKE_CURRENT_BINARY_DIR}/headers_only.cpp")
  endif()
  add_library(rastro_${name} STATIC ${sources})
  set_target_properties(rastro_${name} PROPERTIES LINKER_LANGUAGE CXX)
  target_include_directories(rastro_${name} PUBLIC "${PROJECT_SOURCE_DIR}/src")
  target_link_libraries(rastro_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE} rastro_build_flags)
  foreach(used IN LISTS RASTRO_USES_${name})
    if(TARGET rastro_${used})
      target_link_libraries(rastro_${name} PUBLIC rastro_${used})
    endif()
  endforeach()
  set_property(GLOBAL APPEND PROPERTY RASTRO_MODULES ${name})
endfunction()

# One test program per module, from its *_test.cpp; a module without tests gets none.
function(rastro_add_module_tests)
  include(GoogleTest)
  get_property(modules GLOBAL PROPERTY RASTRO_MODULES)
  foreach(name IN LISTS modules)
    file(GLOB_RECURSE tests CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/rastro/${name}/*_test.cpp"
         "${PROJECT_SOURCE_DIR}/src/rastro/${name}/*_testing.cpp")
    if(tests)
      rastro_add_test(rastro_${name}_test MODULES ${name} synthetic SOURCES ${tests})
    endif()
  endforeach()
endfunction()

# rastro_add_test(TARGET MODULES m... SOURCES f... [LIBRARIES l...]): a GoogleTest program registered with ctest,
# with OpenCV at hand as an oracle. Recorded data is found through RASTRO_DATA of the environment ctest runs in.
function(rastro_add_test target)
  cmake_parse_arguments(arg "" "" "MODULES;SOURCES;LIBRARIES" ${ARGN})
  add_executable(${target} ${arg_SOURCES})
  list(TRANSFORM arg_MODULES PREPEND rastro_)
  target_link_libraries(${target} PRIVATE ${arg_MODULES} ${arg_LIBRARIES} GTest::gmock GTest::gtest_main
    opencv_core opencv_imgproc opencv_imgcodecs opencv_video opencv_calib3d rastro_build_flags)
  target_include_directories(${target} SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
  if(RASTRO_SANITIZERS)
    # What is tested stays at the optimisation of the preset; the tests themselves would take most of the build.
    target_compile_options(${target} PRIVATE -O0)
  endif()
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT 60
    ENVIRONMENT "RASTRO_SOURCE_DIR=${PROJECT_SOURCE_DIR}")
endfunction()

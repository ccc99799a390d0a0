# rastro_module(NAME [PUBLIC lib...] [PRIVATE lib...] [PRECOMPILE header...]): the folder src/rastro/NAME as one internal library.
# Every *.cpp below the folder is a source (main.cpp apart), every *_test.cpp a test, every *_testing.cpp a help to tests; what it may use is read from layers.txt,
# and configuring stops when a line of that table is not sound. TEST_SHARDS n: its tests are
# run in n parts, so that none lasts much over 20 s. All modules together make librastro.
define_property(GLOBAL PROPERTY RASTRO_MODULES BRIEF_DOCS "modules in build order" FULL_DOCS "modules in build order")

# Reads layers.txt once: RASTRO_LAYER_<folder> and RASTRO_USES_<folder> for every folder named there.
function(rastro_read_layers)
  file(STRINGS "${PROJECT_SOURCE_DIR}/layers.txt" lines REGEX "^[0-9]")
  set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/layers.txt")
  foreach(line IN LISTS lines)
    if(NOT line MATCHES "^([0-9]+) ([a-z_/*, ]+):(.*)$")
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
        set(named "${used}")
        cmake_path(GET used PARENT_PATH parent)
        if(NOT DEFINED RASTRO_LAYER_${used} AND DEFINED RASTRO_LAYER_${parent}/*)
          set(named "${parent}/*")  # slam/orb goes by the line of slam/*
        endif()
        if(NOT DEFINED RASTRO_LAYER_${named} OR NOT RASTRO_LAYER_${named} LESS layer)
          message(FATAL_ERROR "layers.txt: '${folder}' (layer ${layer}) uses '${used}', which is not on a lower layer")
        endif()
      endforeach()
    endforeach()
  endforeach()
endfunction()
rastro_read_layers()

# The line of layers.txt that a folder goes by: its own, or that of all folders beside it (slam/*).
function(rastro_layer_line name line)
  cmake_path(GET name PARENT_PATH parent)
  if(DEFINED RASTRO_LAYER_${name})
    set(${line} "${name}" PARENT_SCOPE)
  elseif(DEFINED RASTRO_LAYER_${parent}/*)
    set(${line} "${parent}/*" PARENT_SCOPE)
  else()
    message(FATAL_ERROR "module '${name}' has no line in layers.txt")
  endif()
endfunction()

# A folder below with a CMakeLists.txt of its own (slam/hector) is a module of its own.
function(rastro_without_modules_below folder list)
  set(kept ${${list}})
  file(GLOB_RECURSE modules CONFIGURE_DEPENDS "${folder}/CMakeLists.txt")
  list(REMOVE_ITEM modules "${folder}/CMakeLists.txt")
  foreach(module IN LISTS modules)
    cmake_path(GET module PARENT_PATH below)
    list(FILTER kept EXCLUDE REGEX "^${below}/")
  endforeach()
  set(${list} ${kept} PARENT_SCOPE)
endfunction()

# The modules that an entry of layers.txt stands for: slam/* for all below slam/ so far.
function(rastro_modules_of entry list)
  set(found ${entry})
  if(entry MATCHES "^(.*)/\\*$")
    set(below "^${CMAKE_MATCH_1}/")
    get_property(found GLOBAL PROPERTY RASTRO_MODULES)
    list(FILTER found INCLUDE REGEX "${below}")
  endif()
  set(${list} ${found} PARENT_SCOPE)
endfunction()

# Several sources as one, as compiled_together.txt has them: RASTRO_GROUP_<path> is the group of a source, named after its
# first one, so that a change of the list compiles nothing else again.
file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/compiled_together.txt" groups REGEX "^[^#]")
list(FILTER groups EXCLUDE REGEX "^alone ")
set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${CMAKE_CURRENT_LIST_DIR}/compiled_together.txt")
foreach(group IN LISTS groups)
  string(REPLACE " " ";" paths "${group}")
  list(GET paths 0 first)
  cmake_path(GET first STEM name)
  string(MD5 unique "${first}")
  string(SUBSTRING ${unique} 0 6 unique)
  foreach(path IN LISTS paths)
    set(RASTRO_GROUP_${path} ${name}_${unique})
  endforeach()
endforeach()
function(rastro_compile_together target)
  if(NOT RASTRO_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  foreach(source IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" OUTPUT_VARIABLE relative)
    cmake_path(RELATIVE_PATH relative BASE_DIRECTORY "${PROJECT_SOURCE_DIR}")
    if(DEFINED "RASTRO_GROUP_${relative}")
      set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "${RASTRO_GROUP_${relative}}")
    endif()
  endforeach()
endfunction()

function(rastro_module name)
  cmake_parse_arguments(arg "" "TEST_SHARDS" "PUBLIC;PRIVATE;PRECOMPILE" ${ARGN})
  string(REPLACE "/" "_" target rastro_${name})
  rastro_layer_line(${name} line)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  list(FILTER sources EXCLUDE REGEX "(_test\\.cpp|_testing\\.cpp|/main\\.cpp)$")
  rastro_without_modules_below("${CMAKE_CURRENT_SOURCE_DIR}" sources)
  if(NOT sources)  # a module of headers alone still needs something to archive
    file(CONFIGURE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/headers_only.cpp" CONTENT "")
    set(sources "${CMAKE_CURRENT_BINARY_DIR}/headers_only.cpp")
  endif()
  add_library(${target} STATIC ${sources})
  rastro_compile_together(${target} ${sources})
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX)
  # Includes begin with rastro/, here and in a folder outside of src/ that adds a method of its own (tests/extension).
  string(REGEX REPLACE "/rastro/${name}$" "" root "${CMAKE_CURRENT_SOURCE_DIR}")
  target_include_directories(${target} PUBLIC "${PROJECT_SOURCE_DIR}/src" "${root}")
  target_link_libraries(${target} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE} rastro_build_flags)
  if(name IN_LIST RASTRO_FUZZED_MODULES)
    target_compile_options(${target} PRIVATE -fsanitize-coverage=inline-8bit-counters,pc-table,indirect-calls,trace-cmp)
  endif()
  if(RASTRO_PRECOMPILED_HEADERS AND arg_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE ${rastro_precompiled_headers} ${arg_PRECOMPILE})
  elseif(RASTRO_PRECOMPILED_HEADERS)
    target_precompile_headers(${target} REUSE_FROM rastro_precompiled)
  endif()
  foreach(entry IN LISTS RASTRO_USES_${line})
    rastro_modules_of(${entry} modules)
    foreach(used IN LISTS modules)
      string(REPLACE "/" "_" used_target rastro_${used})
      if(TARGET ${used_target})
        target_link_libraries(${target} PUBLIC ${used_target})
      endif()
    endforeach()
  endforeach()
  set_property(GLOBAL APPEND PROPERTY RASTRO_MODULES ${name})
  set_property(GLOBAL PROPERTY RASTRO_TEST_SHARDS_${name} "${arg_TEST_SHARDS}")
endfunction()

# rastro_method(KIND/NAME [PUBLIC lib...] [PRIVATE lib...]): the folder odometry/NAME or slam/NAME as a module and an entry of the generated list of
# methods. Its method.h declares `std::unique_ptr<OdometryMethod> NAME_odometry_method();` or `std::unique_ptr<SlamMethod> NAME_slam_method();`.
# A static object that registers itself would vanish from a static library.
function(rastro_method name)
  rastro_module(${name} ${ARGN})
  if(NOT TARGET rastro_methods)  # those that come after rastro's own list are for programs that name them
    set_property(GLOBAL APPEND PROPERTY RASTRO_METHODS ${name})
  endif()
endfunction()

# rastro_add_methods(KIND...): every folder below KIND/ that holds a CMakeLists.txt; last those with a line of their own in layers.txt.
function(rastro_add_methods)
  foreach(kind IN LISTS ARGN)
    file(GLOB lists CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/${kind}/*/CMakeLists.txt")
    set(late "")
    foreach(list IN LISTS lists)
      cmake_path(GET list PARENT_PATH folder)
      cmake_path(GET folder FILENAME name)
      if(DEFINED RASTRO_LAYER_${kind}/${name})  # may use the others
        list(APPEND late "${folder}")
      else()
        add_subdirectory("${folder}")
      endif()
    endforeach()
    foreach(folder IN LISTS late)
      add_subdirectory("${folder}")
    endforeach()
  endforeach()
endfunction()

# One function of the generated list, as text: KIND_methods() over those of `names` below KIND/.
function(rastro_method_list kind type names code)
  list(FILTER names INCLUDE REGEX "^${kind}/")
  list(SORT names)
  set(entries "")
  foreach(name IN LISTS names)
    cmake_path(GET name FILENAME method)
    string(APPEND entries "  methods.push_back(${method}_${kind}_method());\n")
  endforeach()
  set(${code} "std::vector<std::unique_ptr<${type}>> ${kind}_methods() {
  std::vector<std::unique_ptr<${type}>> methods;
${entries}  return methods;
}
" PARENT_SCOPE)
endfunction()

# rastro_list_methods(TARGET [KIND/NAME...]): odometry_methods() and slam_methods() as a generated source of the target, over every method of rastro and
# those named here. A program with a list of its own, as one that adds methods, is linked with that one: rastro's is left in its library.
function(rastro_list_methods target)
  get_property(names GLOBAL PROPERTY RASTRO_METHODS)
  list(APPEND names ${ARGN})
  set(includes "")
  foreach(name IN LISTS names)
    string(APPEND includes "#include \"rastro/${name}/method.h\"\n")
    string(REPLACE "/" "_" module rastro_${name})
    target_link_libraries(${target} PUBLIC ${module})
  endforeach()
  rastro_method_list(odometry OdometryMethod "${names}" odometries)
  rastro_method_list(slam SlamMethod "${names}" slams)
  set(file "${CMAKE_CURRENT_BINARY_DIR}/${target}_list.cpp")
  file(CONFIGURE OUTPUT "${file}" CONTENT "// Generated by rastro_list_methods().
#include \"rastro/methods/methods.h\"
${includes}
namespace rastro {

${odometries}
${slams}
}  // namespace rastro
")
  target_sources(${target} PRIVATE "${file}")
  # An object of its own, or the linker could not leave it.
  set_source_files_properties("${file}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# rastro_layer(NAME): an entry of the generated list of map layers. The folder map/NAME defines
# `std::unique_ptr<LayerType> NAME_layer_type();`.
function(rastro_layer name)
  set_property(GLOBAL APPEND PROPERTY RASTRO_MAP_LAYERS ${name})
endfunction()

# Writes the list of every rastro_layer() before, and of the NAMEs given, as a source that defines layer_types(). A
# program with layers of its own compiles such a list: its definition goes before that of the library.
function(rastro_generate_layers file)
  get_property(names GLOBAL PROPERTY RASTRO_MAP_LAYERS)
  list(APPEND names ${ARGN})
  list(SORT names)
  set(declarations "")
  set(entries "")
  foreach(name IN LISTS names)
    string(APPEND declarations "std::unique_ptr<LayerType> ${name}_layer_type();\n")
    string(APPEND entries "    all.push_back(${name}_layer_type());\n")
  endforeach()
  file(CONFIGURE OUTPUT "${file}" CONTENT "// Generated by rastro_generate_layers().
#include \"rastro/map/layer_type.h\"

namespace rastro {

${declarations}
const std::vector<std::unique_ptr<LayerType>>& layer_types() {
  static const std::vector<std::unique_ptr<LayerType>> types = [] {
    std::vector<std::unique_ptr<LayerType>> all;
${entries}    return all;
  }();
  return types;
}

}  // namespace rastro
")
  # An object of its own, or the linker could not leave the library's.
  set_source_files_properties("${file}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# One test program per module, from its *_test.cpp; a module without tests gets none.
function(rastro_add_module_tests)
  include(GoogleTest)
  get_property(modules GLOBAL PROPERTY RASTRO_MODULES)
  foreach(name IN LISTS modules)
    file(GLOB_RECURSE tests CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/rastro/${name}/*_test.cpp"
         "${PROJECT_SOURCE_DIR}/src/rastro/${name}/*_testing.cpp")
    rastro_without_modules_below("${PROJECT_SOURCE_DIR}/src/rastro/${name}" tests)
    if(tests)
      get_property(shards GLOBAL PROPERTY RASTRO_TEST_SHARDS_${name})
      string(REPLACE "/" "_" module ${name})
      rastro_add_test(rastro_${module}_test MODULES ${module} synthetic SOURCES ${tests} SHARDS ${shards})
      if(name STREQUAL "export")  # its tests parse MCAP files
        target_compile_definitions(rastro_export_test PRIVATE RASTRO_WITH_MCAP=$<BOOL:${RASTRO_WITH_MCAP}>)
        target_link_libraries(rastro_export_test PRIVATE ZLIB::ZLIB $<$<BOOL:${RASTRO_WITH_MCAP}>:protobuf::libprotobuf>)
      endif()
      if(name STREQUAL "dataset")  # its tests write bags and recordings of OpenNI2
        target_compile_definitions(rastro_dataset_test PRIVATE RASTRO_WITH_OPENNI2=$<BOOL:${RASTRO_WITH_OPENNI2}>)
        if(RASTRO_WITH_OPENNI2)
          target_include_directories(rastro_dataset_test SYSTEM PRIVATE "${RASTRO_OPENNI2_INCLUDE_DIR}")
        endif()
        target_include_directories(rastro_dataset_test SYSTEM PRIVATE ${RASTRO_ROSBAG_TEST_INCLUDE_DIRS})
        target_compile_definitions(rastro_dataset_test PRIVATE RASTRO_WITH_ROSBAG=$<BOOL:${RASTRO_WITH_ROSBAG}>)
        target_link_libraries(rastro_dataset_test PRIVATE ZLIB::ZLIB ${RASTRO_ROSBAG_TEST_LIBRARIES})
      endif()
    endif()
  endforeach()
endfunction()

# Precompiled headers once more for programs, which are compiled as such; the first one does it for all.
function(rastro_precompile_program target)
  if(NOT RASTRO_PRECOMPILED_HEADERS)
    return()
  endif()
  get_property(owner GLOBAL PROPERTY RASTRO_PRECOMPILED_PROGRAM)
  if(owner)
    target_precompile_headers(${target} REUSE_FROM ${owner})
  else()
    target_precompile_headers(${target} PRIVATE ${rastro_precompiled_headers} <Eigen/Dense> <gmock/gmock.h> <gtest/gtest.h>)
    set_property(GLOBAL PROPERTY RASTRO_PRECOMPILED_PROGRAM ${target})
  endif()
endfunction()

# rastro_add_test(TARGET MODULES m... SOURCES f... [LIBRARIES l...] [SHARDS n | EACH]): a GoogleTest program registered with
# ctest as a whole, in n parts of its tests, or with an entry for each test; with OpenCV at hand as an oracle. A process per test would
# cost more than the tests, and make anew what the tests of a suite share. Recorded data is found through RASTRO_DATA of the
# environment ctest runs in.
function(rastro_add_test target)
  cmake_parse_arguments(arg "EACH" "SHARDS" "MODULES;SOURCES;LIBRARIES" ${ARGN})
  add_executable(${target} ${arg_SOURCES})
  rastro_compile_together(${target} ${arg_SOURCES})
  list(TRANSFORM arg_MODULES PREPEND rastro_)
  target_link_libraries(${target} PRIVATE ${arg_MODULES} ${arg_LIBRARIES} GTest::gmock GTest::gtest_main
    opencv_core opencv_imgproc opencv_imgcodecs opencv_video opencv_calib3d rastro_build_flags)
  target_include_directories(${target} SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)  # a test is compiled longer than it runs
  rastro_precompile_program(${target})
  if(arg_EACH)
    gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT ${RASTRO_TEST_TIMEOUT}
      ENVIRONMENT "RASTRO_SOURCE_DIR=${PROJECT_SOURCE_DIR}")
  else()
    rastro_register_shards(${target} "${arg_SHARDS}")
  endif()
endfunction()

function(rastro_register_shards target shards)
  if(NOT shards)
    set(shards 1)
  endif()
  math(EXPR last "${shards} - 1")
  math(EXPR timeout "5 * ${RASTRO_TEST_TIMEOUT}")  # of many tests together
  foreach(shard RANGE ${last})
    set(name ${target})
    if(shards GREATER 1)
      math(EXPR number "${shard} + 1")
      set(name ${target}.${number})
    endif()
    add_test(NAME ${name} COMMAND ${target} --gtest_brief=1)
    set_tests_properties(${name} PROPERTIES TIMEOUT ${timeout}
      ENVIRONMENT "RASTRO_SOURCE_DIR=${PROJECT_SOURCE_DIR};GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${shard}")
  endforeach()
endfunction()

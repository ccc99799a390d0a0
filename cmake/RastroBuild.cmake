# Language, warnings, sanitizers and third parties for all of rastro's targets.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}")
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
# Asserts of the standard library's own kind stay out of releases; RASTRO_CHECK is always on.
find_program(RASTRO_CCACHE ccache)
if(RASTRO_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${RASTRO_CCACHE}")
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(OpenCV 4 REQUIRED COMPONENTS core imgproc imgcodecs)
if(RASTRO_WITH_VIDEO)
  find_package(OpenCV 4 REQUIRED COMPONENTS core imgproc imgcodecs videoio)
endif()
if(RASTRO_BUILD_PROGRAM)
  find_package(CLI11 REQUIRED)
endif()
if(RASTRO_BUILD_TESTS)
  find_package(GTest REQUIRED)
  # Oracles only: nothing but tests and benchmarks links these OpenCV modules.
  find_package(OpenCV 4 REQUIRED COMPONENTS core imgproc imgcodecs video calib3d)
endif()

# What every target of rastro's own is compiled with; never a global flag.
add_library(rastro_build_flags INTERFACE)
# No contraction: a sum gives the same bits with and without FMA, so SIMD and plain versions can be compared exactly.
target_compile_options(rastro_build_flags INTERFACE -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow
  -Wnon-virtual-dtor -Woverloaded-virtual -Wimplicit-fallthrough -Wno-psabi)
if(RASTRO_WARNINGS_AS_ERRORS)
  target_compile_options(rastro_build_flags INTERFACE -Werror)
endif()
if(RASTRO_SANITIZERS)
  target_compile_options(rastro_build_flags INTERFACE
    -fsanitize=${RASTRO_SANITIZERS} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(rastro_build_flags INTERFACE -fsanitize=${RASTRO_SANITIZERS})
endif()

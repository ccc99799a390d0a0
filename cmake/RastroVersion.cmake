# Writes rastro_version.h into the build tree and gives it to the base module. The commit is the one at configure time.
set(RASTRO_COMMIT "unknown")
find_package(Git QUIET)
if(GIT_FOUND)
  execute_process(COMMAND "${GIT_EXECUTABLE}" describe --always --dirty --abbrev=12 --exclude=*
    WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE commit RESULT_VARIABLE failed
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT failed)
    set(RASTRO_COMMIT "${commit}")
  endif()
endif()
set(RASTRO_VERSION_WITH_VIDEO ${RASTRO_WITH_VIDEO})
set(RASTRO_VERSION_WITH_SURF ${RASTRO_WITH_SURF})
set(RASTRO_VERSION_WITH_ROSBAG ${RASTRO_WITH_ROSBAG})
set(RASTRO_VERSION_WITH_MCAP ${RASTRO_WITH_MCAP})
set(RASTRO_VERSION_WITH_V4L2 ${RASTRO_WITH_V4L2})
set(RASTRO_VERSION_WITH_OPENNI2 ${RASTRO_WITH_OPENNI2})
configure_file("${PROJECT_SOURCE_DIR}/cmake/version.h.in" "${PROJECT_BINARY_DIR}/generated/rastro_version.h" @ONLY)
target_include_directories(rastro_base PRIVATE "${PROJECT_BINARY_DIR}/generated")

# cmake --install: librastro, its headers, the program, CMake package files, man page and bash completion.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/rastro")
install(TARGETS rastro EXPORT rastroTargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
install(EXPORT rastroTargets NAMESPACE rastro:: DESTINATION "${package_dir}")
# Every header but those of tests, of the program, and those that say on their second line that they are internal.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}/src" "${PROJECT_SOURCE_DIR}/src/rastro/*.h")
list(FILTER headers EXCLUDE REGEX "_testing\\.h$|^rastro/cli/")
foreach(header IN LISTS headers)
  file(STRINGS "${PROJECT_SOURCE_DIR}/src/${header}" internal LIMIT_COUNT 1 REGEX "^// Internal: not installed\\.$")
  if(NOT internal)
    get_filename_component(folder "${header}" DIRECTORY)
    install(FILES "${PROJECT_SOURCE_DIR}/src/${header}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/${folder}")
  endif()
endforeach()
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/rastroConfig.cmake.in" "${PROJECT_BINARY_DIR}/rastroConfig.cmake"
  INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/rastroConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/rastroConfig.cmake" "${PROJECT_BINARY_DIR}/rastroConfigVersion.cmake"
  DESTINATION "${package_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")

if(RASTRO_BUILD_PROGRAM AND TARGET rastro_program)
  install(TARGETS rastro_program RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
  # Both pages are made from what the program itself says in --help, so they cannot go stale.
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(pages "${PROJECT_BINARY_DIR}/pages")
  add_custom_command(OUTPUT "${pages}/rastro.1" "${pages}/rastro.bash"
    COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/program_pages.py" "$<TARGET_FILE:rastro_program>" "${pages}"
    DEPENDS rastro_program "${PROJECT_SOURCE_DIR}/scripts/program_pages.py" VERBATIM)
  add_custom_target(rastro_pages ALL DEPENDS "${pages}/rastro.1" "${pages}/rastro.bash")
  install(FILES "${pages}/rastro.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1")
  install(FILES "${pages}/rastro.bash" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" RENAME rastro)
endif()

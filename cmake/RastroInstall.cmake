# cmake --install: librastro, its headers, the program, CMake package files, man page and bash completion.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/rastro")
install(TARGETS rastro EXPORT rastroTargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
install(EXPORT rastroTargets NAMESPACE rastro:: DESTINATION "${package_dir}")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/src/rastro" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
  FILES_MATCHING PATTERN "*.h" PATTERN "*_testing.h" EXCLUDE PATTERN "cli" EXCLUDE)
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

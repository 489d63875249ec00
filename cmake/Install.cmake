# `cmake --install`: headers, library, and the package config that find_package(loopstone) and pkg-config read. Components:
# program, development.

include(CMakePackageConfigHelpers)

set(package_folder "${CMAKE_INSTALL_LIBDIR}/cmake/loopstone")
install(TARGETS loopstone EXPORT loopstone-targets COMPONENT development)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/loopstone" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT development
        FILES_MATCHING PATTERN "*.hpp")
install(EXPORT loopstone-targets NAMESPACE loopstone:: DESTINATION "${package_folder}" COMPONENT development)
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/loopstone-config.cmake.in" loopstone-config.cmake
                              INSTALL_DESTINATION "${package_folder}")
write_basic_package_version_file(loopstone-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/loopstone-config.cmake" "${CMAKE_CURRENT_BINARY_DIR}/loopstone-config-version.cmake"
        DESTINATION "${package_folder}" COMPONENT development)

# Its prefix is told from where the file lies, so that what was installed may be moved.
file(RELATIVE_PATH pc_prefix "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
configure_file("${PROJECT_SOURCE_DIR}/cmake/loopstone.pc.in" loopstone.pc @ONLY)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/loopstone.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT development)

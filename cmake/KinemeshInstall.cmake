# Install rules, and the package files by which find_package(kinemesh) works.
include(CMakePackageConfigHelpers)
set(KINEMESH_CMAKE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/kinemesh")
configure_package_config_file(
  "${CMAKE_SOURCE_DIR}/cmake/kinemeshConfig.cmake.in"
  "${CMAKE_BINARY_DIR}/kinemeshConfig.cmake" INSTALL_DESTINATION "${KINEMESH_CMAKE_DIR}")
write_basic_package_version_file("${CMAKE_BINARY_DIR}/kinemeshConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/kinemeshConfig.cmake"
              "${CMAKE_BINARY_DIR}/kinemeshConfigVersion.cmake"
        DESTINATION "${KINEMESH_CMAKE_DIR}" COMPONENT development)
install(EXPORT kinemeshTargets NAMESPACE kinemesh:: DESTINATION "${KINEMESH_CMAKE_DIR}"
        COMPONENT development)
# ezc3d is in no Debian package: the static library that tools/setup built goes along.
install(DIRECTORY "${KINEMESH_DEPS}/ezc3d/" DESTINATION "${CMAKE_INSTALL_LIBDIR}/kinemesh/ezc3d"
        COMPONENT development PATTERN ".installed" EXCLUDE)

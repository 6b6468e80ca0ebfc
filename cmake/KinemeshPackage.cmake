# cpack makes one Debian package of what `runtime` installs: the command, its man pages and
# completion, the sample sessions, licence and documents. What it depends on is read from the
# program (dpkg-shlibdeps, in the Debian package dpkg-dev).
install(FILES "${CMAKE_SOURCE_DIR}/cmake/package/copyright" DESTINATION share/doc/kinemesh
        COMPONENT runtime)
install(FILES "${CMAKE_SOURCE_DIR}/README.md" "${CMAKE_SOURCE_DIR}/CHANGELOG.md"
        DESTINATION share/doc/kinemesh COMPONENT runtime)
file(GLOB samples CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/sample_c3d/*.c3d"
     "${CMAKE_SOURCE_DIR}/sample_c3d/*.toml")
install(FILES ${samples} "${CMAKE_SOURCE_DIR}/sample_c3d/README.md"
        DESTINATION share/kinemesh/samples COMPONENT runtime)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kinemesh)
set(CPACK_PACKAGE_CONTACT "The Kinemesh authors <kinemesh@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Turns motion-capture sessions into animated meshes")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME kinemesh)
set(CPACK_DEBIAN_RUNTIME_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Text in pictures needs a font, and fontconfig asks for none in particular.
set(CPACK_DEBIAN_PACKAGE_DEPENDS fonts-dejavu-core)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
"Reads recordings of markers (C3D, TRC, CSV), fills gaps, triangulates the markers
of a face, and writes animated meshes for Blender, ParaView and others, with a
report. The samples are in /usr/share/kinemesh/samples.")
include(CPack)

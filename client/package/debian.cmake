# Debian's packages of the C++ client and of treeline-client, by CPack.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME treeline-client)
set(CPACK_PACKAGE_VENDOR "The Treeline authors")
set(CPACK_PACKAGE_CONTACT "The Treeline authors <treeline@localhost>")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_RESOURCE_FILE_LICENSE ${CMAKE_SOURCE_DIR}/LICENSE)
set(CPACK_COMPONENTS_ALL client program)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)

set(CPACK_COMPONENT_CLIENT_DESCRIPTION
  "C++ client of Treeline, which tells a camera where it is\n\
Asks a Treeline server for the pose of a camera in a known place, and keeps\n\
the world in its place between the server's answers. Headers, an archive, and\n\
the wire contract.")
set(CPACK_DEBIAN_CLIENT_PACKAGE_NAME libtreeline-client-dev)
set(CPACK_DEBIAN_CLIENT_PACKAGE_SECTION libdevel)
# What a program that links the archive is compiled and linked with.
set(CPACK_DEBIAN_CLIENT_PACKAGE_DEPENDS
  "libabsl-dev, libdeflate-dev, libgrpc++-dev, libprotobuf-dev, libspng-dev, libturbojpeg0-dev, pkg-config")

set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "asks Treeline servers from a shell, and puts them under load\n\
Localizes pictures, lists scenes, watches a server, and measures how it does\n\
under load.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME treeline-client)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
include(CPack)

add_custom_target(client-packages
  COMMAND ${CMAKE_CPACK_COMMAND} --config ${CMAKE_BINARY_DIR}/CPackConfig.cmake
  WORKING_DIRECTORY ${CMAKE_BINARY_DIR}
  VERBATIM)
add_dependencies(client-packages treeline_client treeline-client)

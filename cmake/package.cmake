# The configuration of CPack that tools/package runs: packages for Debian, one for each component of umax_install.cmake.
# Included by a file that sets SOURCE, BUILD and OUTPUT (folders), VERSION ("0.1.0"), SUITE ("deb12") and PYTHON_MINOR (11).
cmake_policy(VERSION 3.25)
set(CPACK_GENERATOR DEB)
set(CPACK_UMAX_SOURCE ${SOURCE})  # for the script below
set(CPACK_PACKAGE_NAME umax)
set(CPACK_PACKAGE_VERSION ${VERSION})
set(CPACK_PACKAGE_VENDOR "The umax authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "soft bodies that stop deforming exactly where you say")
set(CPACK_PACKAGE_DESCRIPTION ${CPACK_PACKAGE_DESCRIPTION_SUMMARY})
set(CPACK_PACKAGE_CONTACT "The umax authors <umax@packages.debian.org>")
set(CPACK_PACKAGE_DIRECTORY ${OUTPUT})
set(CPACK_PACKAGE_FILE_NAME umax-${VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_SET_DESTDIR OFF)
set(CPACK_CMAKE_GENERATOR Ninja)
set(CPACK_INSTALL_CMAKE_PROJECTS "${BUILD};umax;ALL;/")
set(CPACK_COMPONENTS_ALL program development python)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
  WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${SOURCE}/cmake/debian_files.cmake)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_VERSION ${VERSION}~${SUITE})
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE amd64)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

# debian_package(<component> <name> <section> <description> <packages>)
macro(debian_package component name section text)
  set(packages ${ARGN})
  list(JOIN packages ", " depends)
  set(CPACK_DEBIAN_${component}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${component}_FILE_NAME ${name}_${CPACK_DEBIAN_PACKAGE_VERSION}_amd64.deb)
  set(CPACK_DEBIAN_${component}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${component}_PACKAGE_DEPENDS "${depends}")
  set(CPACK_DEBIAN_${component}_DESCRIPTION "${text}")
endmacro()
set(same_version "umax (= ${CPACK_DEBIAN_PACKAGE_VERSION})")

debian_package(PROGRAM umax graphics
  "Drops a mesh of any kind as a soft body and renders the clip. No element of the\nbody ever stores more elastic energy than you allow, said as a stretch, as an\nenergy density or as an energy, together with frictional contact."
  ffmpeg fonts-dejavu-core libjs-chart.js libjs-three libopenblas0-pthread libosmesa6)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)

file(STRINGS ${SOURCE}/tools/packages headers REGEX "-dev$|^pkg-config$")
debian_package(DEVELOPMENT libumax-dev libdevel
  "Headers, static libraries and the CMake package of umax: bodies, limits,\ncontact and time steps, meshes and cages, pictures, scenes."
  ${same_version} ${headers})

math(EXPR next_minor "${PYTHON_MINOR} + 1")
debian_package(PYTHON python3-umax python
  "Scenes, steps, forces, runs and pictures of umax as numpy arrays, with the\nbytes of the program."
  ${same_version} "python3 (>= 3.${PYTHON_MINOR})" "python3 (<< 3.${next_minor})" python3-numpy)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)

# cmake --install: the program, the libraries with their headers for find_package(umax), the Python module. Each is a component
# of its own: program, development, python.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The program with the helper that it looks for in ../libexec/umax, its pages, what it has built in to be read, licences.
install(TARGETS umax RUNTIME DESTINATION bin COMPONENT program)
install(TARGETS umax_import RUNTIME DESTINATION libexec/umax COMPONENT program)
install(FILES ${PROJECT_BINARY_DIR}/share/man/man1/umax.1 DESTINATION share/man/man1 COMPONENT program)
install(FILES ${PROJECT_BINARY_DIR}/share/bash-completion/completions/umax DESTINATION share/bash-completion/completions
  COMPONENT program)
set(UMAX_ZSH_FOLDER share/zsh/site-functions CACHE STRING "Where the completion of zsh is installed")
install(FILES ${PROJECT_BINARY_DIR}/share/zsh/site-functions/_umax DESTINATION ${UMAX_ZSH_FOLDER} COMPONENT program)
install(DIRECTORY scenes/ DESTINATION share/umax/scenes COMPONENT program FILES_MATCHING PATTERN "*.toml" PATTERN "*.csv")
# The licence of the source, and that of the binary, which every Debian has.
install(FILES LICENSE cmake/copyright DESTINATION share/doc/umax COMPONENT program)
install(FILES /usr/share/common-licenses/GPL-3 DESTINATION share/doc/umax COMPONENT program)

# The libraries: these, and all that stands below them.
set(umax_offered core embedding render scenes setup)

# umax_rooms_below(<result> <targets>): the targets of ours that they link, themselves included
function(umax_rooms_below result)
  set(found "")
  set(left ${ARGN})
  while(left)
    list(POP_FRONT left target)
    if(target MATCHES "^umax::(.*)$")
      set(target umax_${CMAKE_MATCH_1})
    endif()
    if(NOT TARGET ${target} OR NOT target MATCHES "^umax_" OR target IN_LIST found)
      continue()
    endif()
    get_target_property(is_imported ${target} IMPORTED)
    if(NOT is_imported)
      list(APPEND found ${target})
      get_target_property(linked ${target} INTERFACE_LINK_LIBRARIES)
      if(linked)
        list(APPEND left ${linked})
      endif()
    endif()
  endwhile()
  set(${result} ${found} PARENT_SCOPE)
endfunction()
list(TRANSFORM umax_offered PREPEND umax:: OUTPUT_VARIABLE offered)
umax_rooms_below(rooms ${offered})

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/umax)
install(TARGETS ${rooms} EXPORT umax_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/umax COMPONENT development)
install(EXPORT umax_targets NAMESPACE umax:: FILE umax-targets.cmake DESTINATION ${package_folder} COMPONENT development)
configure_package_config_file(cmake/umax-config.cmake.in ${PROJECT_BINARY_DIR}/umax-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/umax-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/umax-config.cmake ${PROJECT_BINARY_DIR}/umax-config-version.cmake
  cmake/umax_packages.cmake DESTINATION ${package_folder} COMPONENT development)

# Headers: those that docs/library.md speaks of, and what they include.
set(umax_headers
  core/base/error.h core/base/parallel.h core/files/read_file.h core/files/write_file.h core/step/step.h
  embedding/cage/voxelize.h embedding/embedding.h embedding/figure/figure.h embedding/mesh_files/mesh_io.h
  embedding/surface/placement.h embedding/surface/shapes.h
  render/image/flip.h render/image/image_io.h render/image/tone_map.h render/raster/rasterize.h
  render/scene/render_scene.h render/trace/path_trace.h
  scenes/builtin_scenes.h scenes/presets.h scenes/resolved_scene.h scenes/scene_file.h
  tools/setup/camera_framing.h tools/setup/limit_report.h tools/setup/simulation_setup.h tools/setup/state_file.h
  tools/setup/stepping.h)
install(CODE "set(source \"${PROJECT_SOURCE_DIR}\")\nset(headers \"${umax_headers}\")" COMPONENT development)
install(SCRIPT cmake/install_headers.cmake COMPONENT development)

# The Python module; four folders below the prefix, from where it finds libexec/umax.
if(TARGET umax_python)
  set(UMAX_PYTHON_FOLDER lib/python${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}/site-packages CACHE STRING
    "Where Python packages are installed")
  install(TARGETS umax_python LIBRARY DESTINATION ${UMAX_PYTHON_FOLDER}/umax COMPONENT python)
  install(DIRECTORY tools/python/umax/ DESTINATION ${UMAX_PYTHON_FOLDER}/umax COMPONENT python
    FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed")
  install(FILES ${PROJECT_BINARY_DIR}/python/umax/_processor.py DESTINATION ${UMAX_PYTHON_FOLDER}/umax COMPONENT python)
endif()

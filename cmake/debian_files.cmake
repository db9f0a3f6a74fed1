# Run by CPack between installing and packing: files where Debian wants them, and those that every package of Debian has.
cmake_policy(VERSION 3.25)
set(names program umax development libumax-dev python python3-umax)

# debian_compress(<file>): by gzip, with no time in it
function(debian_compress file)
  execute_process(COMMAND gzip -9n ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

while(names)
  list(POP_FRONT names component name)
  set(usr ${CPACK_TEMPORARY_DIRECTORY}/${component}/usr)
  if(NOT EXISTS ${usr})
    message(FATAL_ERROR "The component ${component} is not there (looked in ${usr})")
  endif()
  set(doc ${usr}/share/doc/${name})
  file(MAKE_DIRECTORY ${doc})
  file(COPY ${CPACK_UMAX_SOURCE}/cmake/copyright DESTINATION ${doc})  # not file(INSTALL), which would put it below DESTDIR
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  file(WRITE ${doc}/changelog "umax (${CPACK_DEBIAN_PACKAGE_VERSION}) unstable; urgency=medium\n\n  * See CHANGELOG.md of the sources.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  debian_compress(${doc}/changelog)
endwhile()

set(program ${CPACK_TEMPORARY_DIRECTORY}/program/usr)
debian_compress(${program}/share/man/man1/umax.1)
file(REMOVE ${program}/share/doc/umax/LICENSE ${program}/share/doc/umax/GPL-3)  # Debian has them in common-licenses
file(MAKE_DIRECTORY ${program}/share/zsh)
file(RENAME ${program}/share/zsh/site-functions ${program}/share/zsh/vendor-completions)

set(python ${CPACK_TEMPORARY_DIRECTORY}/python/usr/lib)
file(GLOB site ${python}/python3.*/site-packages)
file(MAKE_DIRECTORY ${python}/python3)
file(RENAME ${site} ${python}/python3/dist-packages)
get_filename_component(left ${site} DIRECTORY)
file(REMOVE_RECURSE ${left})

# cmake -DSOURCE=<folder> -DOUTPUT=<file> -P write_commit.cmake: the commit that the folder is at as umax::commit, "-dirty" behind
# it where files differ; empty where there is no telling. The file is written only if that has changed.
execute_process(COMMAND git describe --always --dirty --abbrev=12 --exclude=* WORKING_DIRECTORY ${SOURCE}
  OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
if(NOT EXISTS ${SOURCE}/.git)  # unpacked somewhere within another project
  set(commit "")
endif()
set(text "// Written by write_commit.cmake.\nnamespace umax {\nextern const char* const commit;\n")
string(APPEND text "const char* const commit = \"${commit}\";\n}  // namespace umax\n")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE ${OUTPUT} "${text}")
endif()

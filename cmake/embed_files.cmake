# cmake -DOUTPUT=<file.cpp> -DNAME=<array> -DFILES=<a;b> -P embed_files.cmake: the files as string literals, each with
# its name, in umax::<array> and their number in umax::num_<array>
set(content "// Written by embed_files.cmake.\n#include <cstddef>\n#include <utility>\n\nnamespace umax {\n")
string(APPEND content "extern const std::pair<const char*, const char*> ${NAME}[];\nextern const std::size_t num_${NAME};\n")
string(APPEND content "const std::pair<const char*, const char*> ${NAME}[] = {\n")
list(LENGTH FILES count)
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  file(READ ${file} text)
  string(APPEND content "    {\"${name}\", R\"embedded(${text})embedded\"},\n")
endforeach()
string(APPEND content "};\nconst std::size_t num_${NAME} = ${count};\n}  // namespace umax\n")
file(WRITE ${OUTPUT} "${content}")

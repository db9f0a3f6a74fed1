# Flags that every target of the project shares: one language standard, one floating-point model, one set of
# SIMD flags (Eigen's types change their layout with it), and the project's own warnings.
add_library(umax_options INTERFACE)
target_compile_features(umax_options INTERFACE cxx_std_20)
target_compile_options(umax_options INTERFACE -ffp-contract=off -fno-math-errno)
# The rooms' libraries end in a program or in the Python module: code that runs at any address, and of which nothing is seen
# from outside, so that calls within cost no more than in a program.
target_compile_options(umax_options INTERFACE $<BUILD_INTERFACE:-fPIC> $<BUILD_INTERFACE:-fvisibility=hidden>)
target_include_directories(umax_options INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
  $<INSTALL_INTERFACE:include/umax>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # collecting the compiler's garbage costs a tenth of its time
  target_compile_options(umax_options INTERFACE "$<BUILD_INTERFACE:SHELL:--param ggc-min-heapsize=400000>")
endif()
if(UMAX_ARCH)
  target_compile_options(umax_options INTERFACE -march=${UMAX_ARCH})
endif()
if(UMAX_ARCH STREQUAL "x86-64-v3")  # so that who asks for another instruction set still shares Eigen's memory
  target_compile_definitions(umax_options INTERFACE $<INSTALL_INTERFACE:EIGEN_MAX_ALIGN_BYTES=32>
    $<INSTALL_INTERFACE:EIGEN_MAX_STATIC_ALIGN_BYTES=32>)
endif()
if(UMAX_SANITIZE)
  target_compile_options(umax_options INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(umax_options INTERFACE -fsanitize=address,undefined)
endif()
if(UMAX_RACES)
  target_compile_options(umax_options INTERFACE -fsanitize=thread -Wno-tsan)
  target_link_options(umax_options INTERFACE -fsanitize=thread)
endif()
if(UMAX_FUZZ)  # clang's: what libFuzzer is led by in every file, and what it fails for
  set(fuzz_sanitizers -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize-recover=all)
  target_compile_options(umax_options INTERFACE ${fuzz_sanitizers} -fno-omit-frame-pointer)
  target_compile_definitions(umax_options INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(umax_options INTERFACE ${fuzz_sanitizers})
endif()
if(UMAX_COVERAGE)  # counted in many threads
  target_compile_options(umax_options INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(umax_options INTERFACE --coverage)
endif()

# What nearly every file of the rooms includes is compiled once, in the room named base. A file still includes what it
# uses: -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds without. So does a compiler cache, which keeps no file that has one.
if(CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
set(umax_common_headers <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <tbb/blocked_range.h> <tbb/parallel_for.h>
  <algorithm> <array> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <numbers> <optional> <string>
  <string_view> <variant> <vector>)

add_library(umax_warnings INTERFACE)
target_compile_options(umax_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -Wnon-virtual-dtor -Woverloaded-virtual -Wdouble-promotion)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(umax_warnings INTERFACE -Wno-restrict)  # false alarms on std::string, GCC bug 105651
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)  # more of them, in headers that are then no system headers any more
    target_compile_options(umax_warnings INTERFACE -Wno-array-bounds -Wno-stringop-overflow
      -Wno-stringop-overread)
  endif()
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  # it takes what a function's text argument is made of for what the function's reference refers to
  target_compile_options(umax_warnings INTERFACE -Wno-dangling-reference)
endif()
if(UMAX_WARNINGS_AS_ERRORS)
  target_compile_options(umax_warnings INTERFACE -Werror)
endif()

# umax_file_options(<options> FILES <files>): options of single files, which GCC would forget with precompiled headers
function(umax_file_options options)
  cmake_parse_arguments(arg "" "" "FILES" ${ARGN})
  set_source_files_properties(${arg_FILES} PROPERTIES COMPILE_OPTIONS "${options}" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# umax_kernel_options(<target> <kernel> <files>): one source of kernels, <kernel>_<instruction set>.cpp, compiled for every
# instruction set that the program may find itself on; <files> choose among them
function(umax_kernel_options target kernel)
  set_source_files_properties(${kernel}_portable.cpp PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
    target_sources(${target} PRIVATE ${kernel}_avx2.cpp ${kernel}_avx512.cpp)
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_DEFINITIONS UMAX_X86_KERNELS)
    umax_file_options("-march=x86-64" FILES ${kernel}_portable.cpp)
    umax_file_options("-march=x86-64-v3" FILES ${kernel}_avx2.cpp)
    umax_file_options("-march=x86-64-v4" FILES ${kernel}_avx512.cpp)
  endif()
endfunction()

# umax_room(<name> SOURCES <files> [ROOMS <names>] [PACKAGES <targets>] [FOURS]): the folder's static library umax_<name>
# with the alias umax::<name>. ROOMS: those whose headers it includes; what uses this room may use them too. PACKAGES:
# third-party libraries, which stay inside. FOURS: its files are compiled four at a time, in half the time; they wait for
# headers and not for loops. A file still includes what it uses: the preset dev compiles each alone.
function(umax_room name)
  cmake_parse_arguments(arg "FOURS" "" "SOURCES;ROOMS;PACKAGES" ${ARGN})
  add_library(umax_${name} STATIC ${arg_SOURCES})
  add_library(umax::${name} ALIAS umax_${name})
  set_target_properties(umax_${name} PROPERTIES EXPORT_NAME ${name})
  list(TRANSFORM arg_ROOMS PREPEND umax::)
  target_link_libraries(umax_${name} PUBLIC umax_options Eigen3::Eigen ${arg_ROOMS}
    PRIVATE $<BUILD_INTERFACE:umax_warnings> ${arg_PACKAGES})
  if(name STREQUAL "base")
    target_precompile_headers(umax_base PRIVATE ${umax_common_headers})
  else()
    target_precompile_headers(umax_${name} REUSE_FROM umax_base)
  endif()
  if(arg_FOURS AND NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    set_target_properties(umax_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 4
      # a local name may be another file's constant
      UNITY_BUILD_CODE_BEFORE_INCLUDE "#pragma GCC diagnostic ignored \"-Wshadow\"")
  endif()
endfunction()

# umax_group(<name> ROOMS <names>): umax::<name> stands for all these rooms
function(umax_group name)
  cmake_parse_arguments(arg "" "" "ROOMS" ${ARGN})
  list(TRANSFORM arg_ROOMS PREPEND umax::)
  add_library(umax_${name} INTERFACE)
  add_library(umax::${name} ALIAS umax_${name})
  set_target_properties(umax_${name} PROPERTIES EXPORT_NAME ${name})
  target_link_libraries(umax_${name} INTERFACE ${arg_ROOMS})
endfunction()

# umax_embed(<array> FILES <files>): compiles files in as string literals (see embed_files.cmake) and sets <array> to the
# source file that holds them
function(umax_embed array)
  cmake_parse_arguments(arg "" "" "FILES" ${ARGN})
  list(TRANSFORM arg_FILES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${array}.cpp)
  set(script ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake)
  add_custom_command(OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAME=${array} "-DFILES=${arg_FILES}" -P ${script}
    DEPENDS ${arg_FILES} ${script} VERBATIM)
  set(${array} ${output} PARENT_SCOPE)
endfunction()

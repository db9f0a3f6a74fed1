# Flags that every target of the project shares: one language standard, one floating-point model, one set of
# SIMD flags (Eigen's types change their layout with it), and the project's own warnings.
add_library(umax_options INTERFACE)
target_compile_features(umax_options INTERFACE cxx_std_20)
target_compile_options(umax_options INTERFACE -ffp-contract=off -fno-math-errno)
target_include_directories(umax_options INTERFACE ${PROJECT_SOURCE_DIR})
if(UMAX_ARCH)
  target_compile_options(umax_options INTERFACE -march=${UMAX_ARCH})
endif()
if(UMAX_SANITIZE)
  target_compile_options(umax_options INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(umax_options INTERFACE -fsanitize=address,undefined)
endif()
if(UMAX_COVERAGE)
  target_compile_options(umax_options INTERFACE --coverage)
  target_link_options(umax_options INTERFACE --coverage)
endif()

add_library(umax_warnings INTERFACE)
target_compile_options(umax_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -Wnon-virtual-dtor -Woverloaded-virtual -Wdouble-promotion)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(umax_warnings INTERFACE -Wno-restrict)  # false alarms on std::string, GCC bug 105651
endif()
if(UMAX_WARNINGS_AS_ERRORS)
  target_compile_options(umax_warnings INTERFACE -Werror)
endif()

# umax_library(<room> SOURCES <files> [PUBLIC <targets>] [PRIVATE <targets>]): a static library umax_<room> with the
# alias umax::<room>. Third-party packages go under PRIVATE unless the room's headers show their types.
function(umax_library room)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(umax_${room} STATIC ${arg_SOURCES})
  add_library(umax::${room} ALIAS umax_${room})
  target_link_libraries(umax_${room} PUBLIC umax_options ${arg_PUBLIC} PRIVATE umax_warnings ${arg_PRIVATE})
endfunction()

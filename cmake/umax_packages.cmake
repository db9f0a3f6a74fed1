# The third-party packages, each found once: for the build, and for those who find_package(umax). Debian 12 and 13 name some
# of them differently: that is settled here.
if(TARGET umax_embree)
  return()
endif()
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(fmt REQUIRED)
find_package(assimp REQUIRED)
find_package(tinyobjloader REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(pugixml REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
find_package(OpenEXR 3 REQUIRED)
find_package(Ceres REQUIRED)
pkg_check_modules(CAIRO REQUIRED IMPORTED_TARGET cairo)
pkg_check_modules(LIBCRYPTO REQUIRED IMPORTED_TARGET libcrypto)
pkg_check_modules(OSMESA REQUIRED osmesa)  # its headers: the library is loaded when first needed

# Embree 4 (Debian 13) or 3 (Debian 12), under one name
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3 REQUIRED)
endif()
add_library(umax_embree INTERFACE IMPORTED)
target_link_libraries(umax_embree INTERFACE embree)
target_compile_definitions(umax_embree INTERFACE UMAX_EMBREE_VERSION=${EMBREE_VERSION_MAJOR})

list(APPEND CMAKE_MODULE_PATH /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB)
find_package(OpenVDB REQUIRED)

# Boost.Beast: headers alone
find_path(BEAST_INCLUDE_DIR boost/beast/websocket.hpp REQUIRED)

# Draco: by its name, as the configs of its versions call their targets differently
find_library(DRACO_LIBRARY draco REQUIRED)
find_path(DRACO_INCLUDE_DIR draco/compression/decode.h REQUIRED)
add_library(umax_draco INTERFACE IMPORTED)
target_include_directories(umax_draco SYSTEM INTERFACE ${DRACO_INCLUDE_DIR})
target_link_libraries(umax_draco INTERFACE ${DRACO_LIBRARY})

# CHOLMOD: no CMake config on Debian 12. OpenBLAS is named before it, since CHOLMOD alone would take whatever BLAS the
# machine's alternatives point at, with other last bits; and kept, since a linker that drops libraries would drop it, as
# nothing calls it by name but CHOLMOD.
find_library(OPENBLAS_LIBRARY openblas REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
add_library(umax_cholmod INTERFACE IMPORTED)
target_include_directories(umax_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
target_link_libraries(umax_cholmod INTERFACE -Wl,--push-state,--no-as-needed,${OPENBLAS_LIBRARY},--pop-state
  ${CHOLMOD_LIBRARY} ${CMAKE_DL_LIBS})

# Ceres: the shared library. The static one brings Eigen's functions as its own compiler flags made them, and where the
# linker takes those for ours, memory is freed in another way than it was taken.
find_library(CERES_LIBRARY NAMES libceres.so REQUIRED)
add_library(umax_ceres INTERFACE IMPORTED)
target_include_directories(umax_ceres SYSTEM INTERFACE $<TARGET_PROPERTY:Ceres::ceres,INTERFACE_INCLUDE_DIRECTORIES>)
target_link_libraries(umax_ceres INTERFACE ${CERES_LIBRARY} glog::glog)

# Everything comes from Debian 12 packages; scripts/install-packages names them.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(embree 3 REQUIRED)
find_package(assimp REQUIRED)
find_package(OpenMesh REQUIRED)
find_path(OPENMESH_CONFIG_DIR OpenMesh/Core/System/config.h REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(CGAL 5.5 REQUIRED)
# Ceres' CMake package names its static library, which holds Eigen's functions compiled for other instructions
# than ours. The linker would keep one copy of each, of theirs or ours, and they do not fit together (crashes in
# code that has nothing to do with Ceres). The shared library keeps its own to itself.
find_library(CERES_LIBRARY libceres.so REQUIRED)
find_path(CERES_INCLUDE_DIR ceres/ceres.h REQUIRED)
find_package(glog REQUIRED)
# Their CMake packages do not say which version they are of.
file(STRINGS ${CERES_INCLUDE_DIR}/ceres/version.h parts REGEX "define CERES_VERSION_(MAJOR|MINOR|REVISION) [0-9]+")
string(REGEX REPLACE "[^;]* ([0-9]+)" "\\1" parts "${parts}")
list(JOIN parts "." CERES_VERSION)
file(STRINGS ${OPENMESH_CONFIG_DIR}/OpenMesh/Core/System/config.h number REGEX "^#define OM_VERSION 0x")
string(REGEX REPLACE ".*0x(.)(.).*" "\\1.\\2" OPENMESH_VERSION "${number}")
add_library(ceres_shared SHARED IMPORTED)
set_target_properties(ceres_shared PROPERTIES
  IMPORTED_LOCATION ${CERES_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${CERES_INCLUDE_DIR}
  INTERFACE_LINK_LIBRARIES glog::glog)
find_package(CLI11 REQUIRED)
find_package(toml11 REQUIRED)
find_package(PkgConfig REQUIRED)
# OpenImageIO's CMake package asks for its tools and for OpenCV's headers; its pkg-config file does not.
pkg_check_modules(OIIO REQUIRED IMPORTED_TARGET OpenImageIO)
pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl)
pkg_check_modules(OSMESA REQUIRED IMPORTED_TARGET osmesa)
if(TRUESCATTER_TESTS)
  find_package(GTest REQUIRED)
endif()
if(TRUESCATTER_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()

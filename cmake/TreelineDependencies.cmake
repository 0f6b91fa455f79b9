# Everything comes from Debian 12; scripts/packages.txt names the packages.
find_package(Threads REQUIRED)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
find_package(absl REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(hwy REQUIRED)
# On Arm, NEON and nothing else, called without a choice at run time. With one,
# Highway compiles kernels for SVE, too, whose vectors cannot be members, and marks
# those for NEON as in need of cryptographic instructions, which structs of vectors
# do not get along with, and a Raspberry Pi 4 does not have.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  set_property(TARGET hwy::hwy APPEND PROPERTY
    INTERFACE_COMPILE_DEFINITIONS TOOLCHAIN_MISS_SYS_AUXV_H)
endif()
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
find_package(Protobuf REQUIRED)
find_package(gRPC CONFIG REQUIRED)
find_package(embree 3 REQUIRED)
find_package(spdlog REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(Ceres REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenCV REQUIRED
  COMPONENTS core imgproc features2d calib3d flann videoio)
find_package(PkgConfig REQUIRED)
pkg_check_modules(turbojpeg REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(deflate REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(tinyxml2 REQUIRED IMPORTED_TARGET tinyxml2)
pkg_check_modules(spng REQUIRED IMPORTED_TARGET spng)
pkg_check_modules(lz4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(zstd REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(sqlite3 REQUIRED IMPORTED_TARGET sqlite3)
find_package(BZip2 REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(openni2 REQUIRED IMPORTED_TARGET libopenni2)
pkg_check_modules(libjwt REQUIRED IMPORTED_TARGET libjwt)
find_package(CURL REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto SSL)
pkg_check_modules(httplib REQUIRED IMPORTED_TARGET cpp-httplib)
find_package(octomap REQUIRED)
find_package(CycloneDDS REQUIRED)
find_package(fastcdr REQUIRED)
find_package(fastrtps REQUIRED)
# What its CMake file names besides, /usr/include as a system's folder and
# development files of Boost, would break builds.
find_package(ompl REQUIRED)
find_library(TREELINE_OMPL_LIBRARY ompl REQUIRED)
add_library(treeline_ompl INTERFACE IMPORTED)
target_include_directories(treeline_ompl INTERFACE ${OMPL_INCLUDE_DIR})
target_link_libraries(treeline_ompl INTERFACE ${TREELINE_OMPL_LIBRARY}
  Eigen3::Eigen)

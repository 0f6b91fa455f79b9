# Language level, warnings, sanitizers and the compiler cache, for every target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()

option(TREELINE_WERROR "Turn warnings into errors (CI does)" OFF)
option(TREELINE_FUZZERS "Build the libFuzzer targets (needs clang)" OFF)
set(TREELINE_SANITIZE "" CACHE STRING
    "Value for -fsanitize=, for example address,undefined or thread")

# Objects do not depend on where the checkout lies, so that a clean clone beside
# this one finds them in the compiler cache.
add_compile_options(-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=)
find_program(TREELINE_CCACHE ccache)
if(TREELINE_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=true
    CCACHE_MAXSIZE=20G ${TREELINE_CCACHE})
endif()

# Takes a third of the time that GNU ld takes.
find_program(TREELINE_LLD ld.lld)
if(TREELINE_LLD)
  add_link_options(-fuse-ld=lld)
endif()

add_library(treeline_options INTERFACE)
target_include_directories(treeline_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(treeline_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow
  # g++ 12 invents overlaps in std::string copies (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # ... and uninitialised members of std::optional (GCC bug 80635).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
  $<$<BOOL:${TREELINE_WERROR}>:-Werror>)
# Reductions must give the same bits on every build of one machine type: no
# -ffast-math, and no contraction into fused operations by the compiler's whim.
target_compile_options(treeline_options INTERFACE -ffp-contract=off)
if(TREELINE_FUZZERS)
  target_compile_options(treeline_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(TREELINE_SANITIZE)
  target_compile_options(treeline_options INTERFACE
    -fsanitize=${TREELINE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(treeline_options INTERFACE
    -fsanitize=${TREELINE_SANITIZE})
  if(TREELINE_SANITIZE MATCHES "undefined")
    target_compile_options(treeline_options INTERFACE
      -fno-sanitize-recover=undefined)
  endif()
endif()

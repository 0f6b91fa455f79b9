include(GoogleTest)

# `cmake --build ... --target unit_tests`: what the sanitizers are run on.
add_custom_target(unit_tests)
# Those of what reads bytes from outside: what .ci/run runs the sanitizers on.
add_custom_target(decoder_tests)
# `cmake --build ... --target fuzzers`, in the preset `fuzz`.
add_custom_target(fuzzers)
add_custom_target(benchmarks)
# What scripts/test --long runs: one name a line, and a fuzzer's seeds.
file(WRITE ${CMAKE_BINARY_DIR}/fuzzers.txt "")
file(WRITE ${CMAKE_BINARY_DIR}/benchmarks.txt "")

# treeline_library(NAME SRCS file... DEPS target... [PRIVATE_DEPS target...])
# One folder, one target. PRIVATE_DEPS are what only the .cc files include.
function(treeline_library name)
  cmake_parse_arguments(ARG "" "" "SRCS;DEPS;PRIVATE_DEPS" ${ARGN})
  if(ARG_SRCS)
    add_library(${name} STATIC ${ARG_SRCS})
    target_link_libraries(${name} PUBLIC ${ARG_DEPS}
      PRIVATE treeline_options ${ARG_PRIVATE_DEPS})
    target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE ${ARG_DEPS})
    target_include_directories(${name} INTERFACE ${CMAKE_SOURCE_DIR})
  endif()
endfunction()

# treeline_binary(NAME SRCS file... DEPS target...) -> build/<preset>/bin/NAME
function(treeline_binary name)
  cmake_parse_arguments(ARG "" "" "SRCS;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SRCS})
  target_link_libraries(${name} PRIVATE treeline_options ${ARG_DEPS})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
endfunction()

# treeline_test(NAME [DECODES] SRCS file... DEPS target... [LABELS label...])
# DECODES: it tests what reads bytes from outside.
# One program a folder and label, and one entry of ctest a program: starting a
# process for each case took longer than the cases.
function(treeline_test name)
  cmake_parse_arguments(ARG "DECODES" "" "SRCS;DEPS;LABELS" ${ARGN})
  add_executable(${name} ${ARG_SRCS})
  target_link_libraries(${name} PRIVATE treeline_options ${ARG_DEPS}
    GTest::gmock GTest::gtest_main)
  set(labels unit)
  if(ARG_LABELS)
    set(labels ${ARG_LABELS})
  endif()
  if("unit" IN_LIST labels)
    add_dependencies(unit_tests ${name})
  endif()
  if(ARG_DECODES)
    add_dependencies(decoder_tests ${name})
    list(APPEND labels decoder)
  endif()
  add_test(NAME ${name} COMMAND ${name} --gtest_brief=1)
  set_tests_properties(${name} PROPERTIES LABELS "${labels}" TIMEOUT 1500)
endfunction()

# treeline_benchmark(NAME SRCS file... DEPS target...)
function(treeline_benchmark name)
  treeline_binary(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE benchmark::benchmark)
  add_dependencies(benchmarks ${name})
  file(APPEND ${CMAKE_BINARY_DIR}/benchmarks.txt "${name}\n")
endfunction()

# treeline_fuzzer(NAME SRCS file... DEPS target... [SEEDS folder])
#
# The sources define LLVMFuzzerTestOneInput. Under the preset `fuzz` this is a
# libFuzzer program, build/fuzz/bin/NAME. Everywhere else it is an ordinary
# test, NAME.replay, that feeds the function its seeds and a fixed number of
# mutations of them, so that the sanitizer builds run it too.
function(treeline_fuzzer name)
  cmake_parse_arguments(ARG "" "SEEDS" "SRCS;DEPS" ${ARGN})
  set(seeds)
  if(ARG_SEEDS)
    get_filename_component(seeds ${ARG_SEEDS} ABSOLUTE)
  endif()
  if(TREELINE_FUZZERS)
    treeline_binary(${name} SRCS ${ARG_SRCS} DEPS ${ARG_DEPS})
    target_link_options(${name} PRIVATE -fsanitize=fuzzer)
    add_dependencies(fuzzers ${name})
    file(APPEND ${CMAKE_BINARY_DIR}/fuzzers.txt "${name} ${seeds}\n")
  else()
    treeline_binary(${name}
      SRCS ${ARG_SRCS} ${CMAKE_SOURCE_DIR}/tests/fuzz/replay_main.cc
      DEPS ${ARG_DEPS} treeline_base)
    add_dependencies(unit_tests ${name})
    add_dependencies(decoder_tests ${name})
    add_test(NAME ${name}.replay COMMAND ${name} ${seeds})
    set_tests_properties(${name}.replay PROPERTIES
      LABELS "unit;decoder" TIMEOUT 300)
  endif()
endfunction()

# treeline_python_test(NAME LABEL label SCRIPT file [ARGS argument...] [DEBIAN])
# A check that is a Python program: it passes if it exits with 0. DEBIAN: by
# Debian's Python, whatever else is in the PATH, which has Debian's packages.
function(treeline_python_test name)
  cmake_parse_arguments(ARG "DEBIAN" "LABEL;SCRIPT" "ARGS" ${ARGN})
  set(python ${Python3_EXECUTABLE})
  if(ARG_DEBIAN)
    find_program(TREELINE_DEBIAN_PYTHON python3
      PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
    set(python ${TREELINE_DEBIAN_PYTHON})
  endif()
  add_test(NAME ${name}
    COMMAND ${python} -B ${CMAKE_CURRENT_SOURCE_DIR}/${ARG_SCRIPT}
            ${ARG_ARGS})
  set_tests_properties(${name} PROPERTIES
    LABELS ${ARG_LABEL} TIMEOUT 300)
endfunction()

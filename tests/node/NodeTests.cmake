# Tests with node: packages that npm fetches, pages that it builds, and pages in
# a browser. Each is skipped, in words, where node, npm, npm's registry or
# chromium is missing.
find_program(TREELINE_NODE node)
find_program(TREELINE_NPM npm)
set(TREELINE_NODE_TESTS ${CMAKE_CURRENT_LIST_DIR})

# needs_node(NAME): without node and npm NAME is skipped, and the calling
# CMakeLists.txt ends.
macro(needs_node name)
  if(NOT TREELINE_NODE OR NOT TREELINE_NPM)
    add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} -E echo
      "SKIPPED: no node and npm on this machine")
    set_tests_properties(${name} PROPERTIES
      LABELS integration SKIP_REGULAR_EXPRESSION "SKIPPED")
    return()
  endif()
endmacro()

# node_packages(NAME FOLDER FIXTURE fixture [LABEL label] FILES file...): copies
# package.json, package-lock.json and FILES into FOLDER, so that node_modules
# stays out of the source tree, and fetches there what package-lock.json says,
# from npm's cache where it is there already.
function(node_packages name folder)
  cmake_parse_arguments(ARG "" "FIXTURE;LABEL" "FILES" ${ARGN})
  foreach(file IN ITEMS package.json package-lock.json ${ARG_FILES})
    configure_file(${file} ${folder}/${file} COPYONLY)
  endforeach()
  set(label integration)
  if(ARG_LABEL)
    set(label ${ARG_LABEL})
  endif()
  add_test(NAME ${name}
    COMMAND ${CMAKE_COMMAND} -D NPM=${TREELINE_NPM}
            -P ${TREELINE_NODE_TESTS}/npm_ci.cmake
    WORKING_DIRECTORY ${folder})
  set_tests_properties(${name} PROPERTIES
    LABELS ${label} TIMEOUT 300 FIXTURES_SETUP ${ARG_FIXTURE}
    SKIP_REGULAR_EXPRESSION "SKIPPED")
endfunction()

# node_test(NAME file.js FOLDER folder PACKAGE package [IMPORT file.js]
#   FIXTURES fixture... ENVIRONMENT VARIABLE=value...): runs a file of a folder
# of node_packages, which is skipped if PACKAGE could not be fetched.
function(node_test name file)
  cmake_parse_arguments(ARG "" "FOLDER;PACKAGE;IMPORT" "FIXTURES;ENVIRONMENT"
    ${ARGN})
  add_test(NAME ${name}
    COMMAND ${CMAKE_COMMAND} -D NODE=${TREELINE_NODE} -D TEST=${file}
            -D PACKAGE=${ARG_PACKAGE} -D IMPORT=${ARG_IMPORT}
            -P ${TREELINE_NODE_TESTS}/run_test.cmake
    WORKING_DIRECTORY ${ARG_FOLDER})
  set_tests_properties(${name} PROPERTIES
    LABELS integration TIMEOUT 300 SKIP_REGULAR_EXPRESSION "SKIPPED"
    FIXTURES_REQUIRED "${ARG_FIXTURES}" ENVIRONMENT "${ARG_ENVIRONMENT}")
endfunction()

# npm_build(NAME script OUT folder WORK folder FIXTURE fixture): types, unit
# tests and build of a page or package by scripts/SCRIPT, outside the source
# tree.
function(npm_build name script)
  cmake_parse_arguments(ARG "" "OUT;WORK;FIXTURE" "" ${ARGN})
  add_test(NAME ${name}
    COMMAND ${CMAKE_SOURCE_DIR}/scripts/${script} --check
            --out ${ARG_OUT} --work ${ARG_WORK})
  set_tests_properties(${name} PROPERTIES
    LABELS integration TIMEOUT 600 SKIP_RETURN_CODE 77
    FIXTURES_SETUP ${ARG_FIXTURE})
endfunction()

# browser_test(NAME file.js NEEDS file... ENVIRONMENT VARIABLE=value...
#   FIXTURES fixture...): a test with node and a browser, one at a time, since a
# browser that draws without a GPU takes a core or two; mostly they wait, and
# other tests run beside them. The first to be started. Skipped where a file of
# NEEDS or chromium is missing.
function(browser_test name file)
  cmake_parse_arguments(ARG "" "" "NEEDS;ENVIRONMENT;FIXTURES" ${ARGN})
  add_test(NAME ${name}
    COMMAND ${CMAKE_COMMAND} -D NODE=${TREELINE_NODE}
            -D TEST=${CMAKE_CURRENT_SOURCE_DIR}/${file} -D "NEEDS=${ARG_NEEDS}"
            -P ${TREELINE_NODE_TESTS}/run_browser.cmake)
  set_tests_properties(${name} PROPERTIES
    LABELS integration TIMEOUT 600 SKIP_REGULAR_EXPRESSION "SKIPPED"
    RESOURCE_LOCK browser COST 100 FIXTURES_REQUIRED "${ARG_FIXTURES}"
    ENVIRONMENT "${ARG_ENVIRONMENT}")
endfunction()

# browser_test(NAME file.js NEEDS file... ENVIRONMENT VARIABLE=value...
#   FIXTURES fixture...): a test with node and a browser, alone on the machine,
# since a browser that draws without a GPU takes both cores. Skipped, in words,
# where a file of NEEDS or chromium is missing.
set(TREELINE_BROWSER_RUNNER ${CMAKE_CURRENT_LIST_DIR}/run_browser.cmake)
function(browser_test name file)
  cmake_parse_arguments(ARG "" "" "NEEDS;ENVIRONMENT;FIXTURES" ${ARGN})
  add_test(NAME ${name}
    COMMAND ${CMAKE_COMMAND} -D NODE=${TREELINE_NODE}
            -D TEST=${CMAKE_CURRENT_SOURCE_DIR}/${file} -D "NEEDS=${ARG_NEEDS}"
            -P ${TREELINE_BROWSER_RUNNER})
  set_tests_properties(${name} PROPERTIES
    LABELS integration TIMEOUT 600 SKIP_REGULAR_EXPRESSION "SKIPPED"
    RUN_SERIAL TRUE FIXTURES_REQUIRED "${ARG_FIXTURES}"
    ENVIRONMENT "${ARG_ENVIRONMENT}")
endfunction()

# Runs a test with node, where npm_ci.cmake has fetched what it needs:
#   cmake -D NODE=program -D TEST=file.js -P run_test.cmake
if(NOT EXISTS node_modules/@mcap/core/package.json)
  message("SKIPPED: npm's registry could not be reached")
  return()
endif()
execute_process(COMMAND ${NODE} --test ${TEST} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${TEST} failed")
endif()

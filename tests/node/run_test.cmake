# Runs a test with node, where npm_ci.cmake has fetched what it needs:
#   cmake -D NODE=program -D TEST=file.js -D PACKAGE=name [-D IMPORT=file.js]
#         -P run_test.cmake
if(NOT EXISTS node_modules/${PACKAGE}/package.json)
  message("SKIPPED: npm's registry could not be reached")
  return()
endif()
if(IMPORT)
  set(import --import ./${IMPORT})
endif()
execute_process(
  COMMAND ${NODE} ${import} --test ${TEST} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${TEST} failed")
endif()

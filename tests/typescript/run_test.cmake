# Runs a test of the package with node, if there is a package:
#   cmake -D NODE=program -D TEST=file.js -D PACKAGE=folder -D WORK=folder
#         -D ROOT=folder -P run_test.cmake
file(GLOB package ${PACKAGE}/treeline-client-*.tgz)
if(NOT package OR NOT EXISTS ${WORK}/node_modules/.fetched)
  message("SKIPPED: the package could not be built here (test typescript.build)")
  return()
endif()
set(ENV{TREELINE_PACKAGE} ${package})
set(ENV{TREELINE_PACKAGE_WORK} ${WORK})
set(ENV{TREELINE_ROOT} ${ROOT})
execute_process(COMMAND ${NODE} --test ${TEST} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${TEST} failed")
endif()

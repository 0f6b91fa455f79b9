# Fetches the packages of package-lock.json into node_modules:
#   cmake -D NPM=program -P npm_ci.cmake
# A registry that cannot be reached is no fault of ours: the tests that need the
# packages say that they were skipped.
execute_process(
  COMMAND ${NPM} ci --prefer-offline --no-audit --no-fund --ignore-scripts
  RESULT_VARIABLE result ERROR_VARIABLE error)
if(result EQUAL 0)
  return()
endif()
if(error MATCHES "ENOTFOUND|EAI_AGAIN|ECONNREFUSED|ECONNRESET|ETIMEDOUT|EHOSTUNREACH|ENETUNREACH")
  message("SKIPPED: npm's registry cannot be reached: ${error}")
  return()
endif()
message(FATAL_ERROR "npm ci: ${error}")

# Learns a recording for the page about it: cmake -D TREELINE=program
# -D RECORDING=folder -D OUTPUT=folder -P make_learn_page.cmake
file(REMOVE_RECURSE ${OUTPUT} ${OUTPUT}-models)
execute_process(
  COMMAND ${TREELINE} learn tum:${RECORDING} --scene learnt --only-tested
          --trees 2 --quiet --output ${OUTPUT} --repository ${OUTPUT}-models
  RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "treeline learn: exit code ${result}")
endif()

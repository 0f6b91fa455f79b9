# Records a walk through a synthetic room with a camera whose intrinsics are
# known, and learns it: cmake -D TREELINE=program -D OUTPUT=folder
# -P make_scene.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}: exit code ${result}")
  endif()
endfunction()

file(REMOVE_RECURSE ${OUTPUT})
file(MAKE_DIRECTORY ${OUTPUT})
run(${TREELINE} synth record --world room --frames 120 --rate 8 --format tum
    --quiet --output ${OUTPUT}/recording)
run(${TREELINE} train --dataset tum:${OUTPUT}/recording
    --frames ${OUTPUT}/recording/train.txt --trees 2 --quiet
    --repository ${OUTPUT}/models --scene room)

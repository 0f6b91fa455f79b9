# Records a walk through a synthetic room and learns it, once for all tests of
# this folder: cmake -D TREELINE=program -D OUTPUT=folder -P make_scene.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}: exit code ${result}")
  endif()
endfunction()

file(REMOVE_RECURSE ${OUTPUT})
file(MAKE_DIRECTORY ${OUTPUT})
run(${TREELINE} synth record --world room --frames 80
    --output ${OUTPUT}/recording)
run(${TREELINE} train --dataset 7scenes:${OUTPUT}/recording
    --frames ${OUTPUT}/recording/train.txt --method rgbd --trees 2
    --quiet --output ${OUTPUT}/room.treeline)

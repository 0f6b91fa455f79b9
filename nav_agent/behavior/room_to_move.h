// How much room a lost robot has to move.
#ifndef NAV_AGENT_BEHAVIOR_ROOM_TO_MOVE_H_
#define NAV_AGENT_BEHAVIOR_ROOM_TO_MOVE_H_

#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/control/local_controller.h"

namespace treeline::behavior {

// Fills in what `controller` knows of the room around the robot: whether it can
// turn, and the ways that are free ahead and, where nobody may come up behind
// it, behind.
void NoteRoom(const control::LocalController& controller,
              const control::ControlPose& pose, RelocalizationInput& input);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_ROOM_TO_MOVE_H_

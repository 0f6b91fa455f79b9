#include "nav_agent/behavior/room_to_move.h"

#include <cmath>

#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {

void NoteRoom(const control::LocalController& controller,
              const control::ControlPose& pose, RelocalizationInput& input) {
  input.can_turn = controller.CanTurn(pose);
  input.free_ahead_m = controller.FreeWay_m(pose, kMaxAskAhead_m);
  if (controller.QuietFor_s(input.now) >= kNobodyMovedFor_s) {
    input.free_behind_m = std::abs(controller.FreeWay_m(pose, -kBackUp_m));
  }
}

}  // namespace treeline::behavior

// A pose as people read it.
#ifndef NAV_AGENT_BEHAVIOR_PLACE_TEXT_H_
#define NAV_AGENT_BEHAVIOR_PLACE_TEXT_H_

#include <string>

#include "absl/strings/str_format.h"
#include "nav_agent/core/level_pose.h"

namespace treeline::behavior {

// "(1.00, 2.00) on level 0".
inline std::string PlaceText(const core::LevelPose& pose) {
  return absl::StrFormat("(%.2f, %.2f) on level %d",
                         pose.map_from_base.translation.x,
                         pose.map_from_base.translation.y, pose.place.level);
}

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PLACE_TEXT_H_

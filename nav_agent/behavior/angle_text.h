// Angles in texts for people.
#ifndef NAV_AGENT_BEHAVIOR_ANGLE_TEXT_H_
#define NAV_AGENT_BEHAVIOR_ANGLE_TEXT_H_

#include <numbers>

namespace treeline::behavior {

inline double InDegrees(double angle_rad) {
  return angle_rad * (180 / std::numbers::pi);
}

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_ANGLE_TEXT_H_

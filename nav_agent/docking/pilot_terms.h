// What a dock pilot asks of a navigator, and says of a dock.
#ifndef NAV_AGENT_DOCKING_PILOT_TERMS_H_
#define NAV_AGENT_DOCKING_PILOT_TERMS_H_

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "absl/strings/str_format.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/docking/dock.h"

namespace treeline::docking {

// Whether a goal is not over.
inline bool IsActive(const std::optional<behavior::GoalStatus>& goal) {
  return goal.has_value() && (goal->state == behavior::GoalState::kAccepted ||
                              goal->state == behavior::GoalState::kActive);
}

// Whether it looks for its place.
inline bool IsLost(behavior::NavigatorMode mode) {
  return mode == behavior::NavigatorMode::kLost ||
         mode == behavior::NavigatorMode::kRelocalizing ||
         mode == behavior::NavigatorMode::kNeedHelp;
}

// A pose at a dock.
inline core::LevelPose OnLevel(const Dock& dock, const geometry::Rigid2& pose) {
  return {.map_from_base = pose, .place = {.level = dock.level, .height_m = 0}};
}

// For people.
inline std::string OffText(const DockOffset& off) {
  return absl::StrFormat("%.1f cm and %.1f degrees off",
                         100 * std::hypot(off.along_m, off.aside_m),
                         std::abs(off.turned_rad) * 180 / std::numbers::pi);
}

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_PILOT_TERMS_H_

// Poses between the parts of a navigator.
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_POSES_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_POSES_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/behavior/safe_stop.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline::behavior {

bool IsFinite(const core::LevelPose& pose);
// INVALID_ARGUMENT: not finite, or on none of so many levels; `what` ("a goal")
// names it.
absl::Status CheckOnLevels(const core::LevelPose& pose, const std::string& what,
                           int levels);

// FAILED_PRECONDITION: it lies in what `zones` (null: none) keep out of.
absl::Status CheckNotKeptOut(const core::LevelPose& pose,
                             const std::string& what,
                             const zones::ZoneMap* zones);

// What the navigator is told to do at a dock, of a map with so many levels.
// INVALID_ARGUMENT: not finite, or on no level. FAILED_PRECONDITION: as
// CheckNotKeptOut.
absl::Status CheckSteering(const SteeringCommand& steering, int levels,
                           const zones::ZoneMap* zones);

// The robot stands if its estimate is old, or not finite.
std::optional<StopReason> EstimateProblem(
    const std::optional<control::ControlPose>& pose, base::MonotonicTime now);

// In the wheels' frame: where that is on the map is not known.
std::optional<control::ControlPose> ControlPoseOf(
    const std::optional<localization::TrackedMotion>& motion);
// In the map's.
std::optional<control::ControlPose> ControlPoseOf(
    const std::optional<localization::TrackedPose>& pose);

// Where a lost robot may be, as far as that is known: the place that it turns
// to confirm, or those of at least kSupposedShare that its search by laser has
// left, the likeliest first.
std::vector<core::LevelPose> SupposedPlaces(
    const localization::TrackedPose& pose, RelocalizationState state);
// Nothing else is left: what the map has there is no supposition any more.
bool IsOnlyPlace(const localization::TrackedPose& pose);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NAVIGATOR_POSES_H_

// Where a robot thought it was when it began to look for its place: it goes
// back to that if it finds no other.
#ifndef NAV_AGENT_BEHAVIOR_PLACE_BEFORE_H_
#define NAV_AGENT_BEHAVIOR_PLACE_BEFORE_H_

#include <cstddef>
#include <optional>

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

// Not thread-safe.
class PlaceBefore {
 public:
  PlaceBefore() = default;
  explicit PlaceBefore(const localization::RobotTracker& tracker)
      : pose_(tracker.Pose()), motion_(tracker.Motion()) {}

  // The tracker was told another place since.
  void NoteTold() { was_told_ = true; }

  // Tells the tracker the place before, carried on by the wheels and a little
  // less well known, if it was told another one since.
  void Restore(localization::RobotTracker& tracker,
               const traversability::NavigationMap& map,
               base::MonotonicTime now) {
    const std::optional<localization::TrackedMotion> motion = tracker.Motion();
    if (!was_told_ || !pose_.has_value() || !motion_.has_value() ||
        !motion.has_value()) {
      return;
    }
    was_told_ = false;
    localization::PoseCovariance2 covariance = pose_->covariance;
    for (const size_t i : {size_t{0}, size_t{4}, size_t{8}}) {
      covariance[i] += kRestoredVariance;
    }
    tracker
        .SetPose(PropagatedByOdometry(pose_->pose, *motion_, *motion, map),
                 covariance, now)
        .IgnoreError();
  }

 private:
  std::optional<localization::TrackedPose> pose_;
  std::optional<localization::TrackedMotion> motion_;
  bool was_told_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PLACE_BEFORE_H_

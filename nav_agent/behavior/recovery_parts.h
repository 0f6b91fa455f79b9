// What the parts of a recovery share.
#ifndef NAV_AGENT_BEHAVIOR_RECOVERY_PARTS_H_
#define NAV_AGENT_BEHAVIOR_RECOVERY_PARTS_H_

#include <chrono>

#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

inline double SecondsBetween(base::MonotonicTime from, base::MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
}

// Where a robot that was at `pose` is after the wheels' motion.
inline core::LevelPose CarriedOn(const core::LevelPose& pose,
                                 const localization::TrackedMotion& from,
                                 const localization::TrackedMotion& to,
                                 const traversability::NavigationMap& map) {
  core::LevelPose carried = pose;
  carried.map_from_base =
      pose.map_from_base * (from.odom_from_base.Inverse() * to.odom_from_base);
  carried.place =
      map.GroundNear(carried.map_from_base.translation, pose.place.height_m)
          .value_or(pose.place);
  return carried;
}

// In [-1, 1].
inline double ScoreOf(const localization::RobotTracker::ScanFit& fit) {
  return fit.explained - fit.contradicted;
}

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RECOVERY_PARTS_H_

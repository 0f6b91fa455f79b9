// What the parts of a recovery share.
#ifndef NAV_AGENT_BEHAVIOR_RECOVERY_PARTS_H_
#define NAV_AGENT_BEHAVIOR_RECOVERY_PARTS_H_

#include <chrono>

#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline {

inline double SecondsBetween(MonotonicTime from, MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
}

// Where a robot that was at `pose` is after the wheels' motion.
inline LevelPose CarriedOn(const LevelPose& pose, const TrackedMotion& from,
                           const TrackedMotion& to, const NavigationMap& map) {
  LevelPose carried = pose;
  carried.map_from_base =
      pose.map_from_base * (from.odom_from_base.Inverse() * to.odom_from_base);
  carried.place =
      map.GroundNear(carried.map_from_base.translation, pose.place.height_m)
          .value_or(pose.place);
  return carried;
}

// In [-1, 1].
inline double ScoreOf(const RobotTracker::ScanFit& fit) {
  return fit.explained - fit.contradicted;
}

}  // namespace treeline

#endif  // NAV_AGENT_BEHAVIOR_RECOVERY_PARTS_H_

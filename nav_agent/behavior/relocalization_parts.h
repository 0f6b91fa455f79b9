// What the parts of a recovery share.
#ifndef NAV_AGENT_BEHAVIOR_RELOCALIZATION_PARTS_H_
#define NAV_AGENT_BEHAVIOR_RELOCALIZATION_PARTS_H_

#include <cmath>
#include <string>

#include "absl/strings/str_format.h"
#include "nav_agent/behavior/angle_text.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

// Where a robot that was at `pose` is after the wheels' motion.
inline core::LevelPose PropagatedByOdometry(
    const core::LevelPose& pose, const localization::TrackedMotion& from,
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

// As seen from above, and in height.
inline bool AreWithin(const core::LevelPose& a, const core::LevelPose& b,
                      double max_m, double max_rad) {
  return geometry::Norm(a.map_from_base.translation -
                        b.map_from_base.translation) <= max_m &&
         std::abs(geometry::NormalizedAngle_rad(
             a.map_from_base.yaw_rad - b.map_from_base.yaw_rad)) <= max_rad &&
         std::abs(a.place.height_m - b.place.height_m) <= max_m;
}

// "1.20, 3.40 on level 0, 90 degrees": for people.
inline std::string PoseText(const core::LevelPose& pose) {
  return absl::StrFormat("%.2f, %.2f on level %d, %.0f degrees",
                         pose.map_from_base.translation.x,
                         pose.map_from_base.translation.y, pose.place.level,
                         InDegrees(pose.map_from_base.yaw_rad));
}

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RELOCALIZATION_PARTS_H_

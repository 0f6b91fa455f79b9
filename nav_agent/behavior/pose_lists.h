// Lists of poses: what a goal is given as, and what a path is.
#ifndef NAV_AGENT_BEHAVIOR_POSE_LISTS_H_
#define NAV_AGENT_BEHAVIOR_POSE_LISTS_H_

#include <cmath>
#include <cstddef>
#include <vector>

#include "nav_agent/core/level_pose.h"

namespace treeline::behavior {

inline double Distance_m(const core::LevelPose& a, const core::LevelPose& b) {
  return geometry::Norm(a.map_from_base.translation -
                        b.map_from_base.translation);
}

// How far the two are turned against each other, in [0, pi].
inline double HeadingOff_rad(const core::LevelPose& a,
                             const core::LevelPose& b) {
  return std::abs(geometry::NormalizedAngle_rad(a.map_from_base.yaw_rad -
                                                b.map_from_base.yaw_rad));
}

// Poses that are driven through look to where the way goes there: half from
// where it comes, half to where it leads. The last keeps its heading.
inline void HeadAlong(std::vector<core::LevelPose>& poses) {
  for (size_t i = 0; i + 1 < poses.size(); ++i) {
    const geometry::Vec2 here = poses[i].map_from_base.translation;
    const geometry::Vec2 on = poses[i + 1].map_from_base.translation - here;
    geometry::Vec2 way = geometry::Norm(on) > 0 ? (1 / geometry::Norm(on)) * on
                                                : geometry::Vec2{1, 0};
    if (i > 0) {
      const geometry::Vec2 in = here - poses[i - 1].map_from_base.translation;
      // A little less, for ways that lead straight back.
      if (geometry::Norm(in) > 0) way = way + (0.99 / geometry::Norm(in)) * in;
    }
    poses[i].map_from_base.yaw_rad = std::atan2(way.y, way.x);
  }
}

// What is left of a path, from where the robot is nearest to it.
inline std::vector<core::LevelPose> RestOf(
    const std::vector<core::LevelPose>& path, const core::LevelPose& robot) {
  size_t nearest = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    if (Distance_m(path[i], robot) < Distance_m(path[nearest], robot)) {
      nearest = i;
    }
  }
  return {path.begin() + static_cast<std::ptrdiff_t>(nearest), path.end()};
}

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_POSE_LISTS_H_

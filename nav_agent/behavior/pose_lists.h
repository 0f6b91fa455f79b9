// Lists of poses: what a goal is given as, and what a path is.
#ifndef NAV_AGENT_BEHAVIOR_POSE_LISTS_H_
#define NAV_AGENT_BEHAVIOR_POSE_LISTS_H_

#include <cmath>
#include <cstddef>
#include <vector>

#include "nav_agent/core/level_pose.h"

namespace treeline {

inline double Distance_m(const LevelPose& a, const LevelPose& b) {
  return Norm(a.map_from_base.translation - b.map_from_base.translation);
}

// Poses that are driven through look to where the way goes there: half from
// where it comes, half to where it leads. The last keeps its heading.
inline void HeadAlong(std::vector<LevelPose>& poses) {
  for (size_t i = 0; i + 1 < poses.size(); ++i) {
    const Vec2 here = poses[i].map_from_base.translation;
    const Vec2 on = poses[i + 1].map_from_base.translation - here;
    Vec2 way = Norm(on) > 0 ? (1 / Norm(on)) * on : Vec2{1, 0};
    if (i > 0) {
      const Vec2 in = here - poses[i - 1].map_from_base.translation;
      // A little less, for ways that lead straight back.
      if (Norm(in) > 0) way = way + (0.99 / Norm(in)) * in;
    }
    poses[i].map_from_base.yaw_rad = std::atan2(way.y, way.x);
  }
}

// What is left of a path, from where the robot is nearest to it.
inline std::vector<LevelPose> RestOf(const std::vector<LevelPose>& path,
                                     const LevelPose& robot) {
  size_t nearest = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    if (Distance_m(path[i], robot) < Distance_m(path[nearest], robot)) {
      nearest = i;
    }
  }
  return {path.begin() + static_cast<std::ptrdiff_t>(nearest), path.end()};
}

}  // namespace treeline

#endif  // NAV_AGENT_BEHAVIOR_POSE_LISTS_H_

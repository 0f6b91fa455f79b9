#include "nav_agent/mapping/trajectory_pose.h"

namespace treeline::mapping {

geometry::Rigid3 MapFromBase(const TrajectoryPose& pose) {
  const geometry::Vec2 at = pose.map_from_base.translation;
  return {.rotation = geometry::Rotation3::FromAxisAngle(
                          {0, 0, pose.map_from_base.yaw_rad}) *
                      pose.level_from_base,
          .translation = {at.x, at.y, pose.height_m}};
}

}  // namespace treeline::mapping

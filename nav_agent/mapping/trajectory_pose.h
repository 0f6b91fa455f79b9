// A robot's place along its way, in the plane and in space.
#ifndef NAV_AGENT_MAPPING_TRAJECTORY_POSE_H_
#define NAV_AGENT_MAPPING_TRAJECTORY_POSE_H_

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::mapping {

struct TrajectoryPose {
  recording::RecordingTime stamp;
  geometry::Rigid2 map_from_base;
  // Above the first scan, and as the scan says; see MapFromBase.
  double height_m = 0;
  geometry::Rotation3 level_from_base{};
  // False: nobody knows where the robot was (LaserSlamOptions::carries), and
  // the rest means nothing.
  bool is_known = true;
};

// In space: Rz(yaw) level_from_base, at (x, y, height).
geometry::Rigid3 MapFromBase(const TrajectoryPose& pose);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_TRAJECTORY_POSE_H_

// Poses as the six numbers that a solver moves.
#ifndef NAV_AGENT_RGBD_SLAM_POSE_BLOCK_H_
#define NAV_AGENT_RGBD_SLAM_POSE_BLOCK_H_

#include <array>

#include "common/geometry/rigid3.h"

namespace treeline::rgbd_slam {

// Axis and angle (rad), then translation (m).
using PoseBlock = std::array<double, 6>;

inline PoseBlock ToBlock(const geometry::Rigid3& pose) {
  const geometry::Vec3 turn = geometry::ToAxisAngle(pose.rotation);
  const geometry::Vec3 t = pose.translation;
  return {turn.x, turn.y, turn.z, t.x, t.y, t.z};
}

inline geometry::Rigid3 FromBlock(const PoseBlock& block) {
  return {.rotation = geometry::Rotation3::FromAxisAngle(
              {block[0], block[1], block[2]}),
          .translation = {block[3], block[4], block[5]}};
}

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_POSE_BLOCK_H_

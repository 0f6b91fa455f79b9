// Two estimates of one pose, each with its covariance, made one.
#ifndef SERVER_CORE_POSE_POSE_FUSION_H_
#define SERVER_CORE_POSE_POSE_FUSION_H_

#include <optional>

#include "common/geometry/rigid3.h"

namespace treeline::pose {

struct PoseWithCovariance {
  geometry::Rigid3 world_from_camera;
  geometry::PoseCovariance covariance{};
};

// The maximum likelihood pose of two independent estimates that differ by a
// small rotation. nullopt: a covariance is singular or not finite.
std::optional<PoseWithCovariance> FusePoses(const PoseWithCovariance& a,
                                            const PoseWithCovariance& b);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_POSE_FUSION_H_

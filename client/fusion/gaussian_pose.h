// A pose that is known up to a normal distribution.
#ifndef CLIENT_FUSION_GAUSSIAN_POSE_H_
#define CLIENT_FUSION_GAUSSIAN_POSE_H_

#include "common/geometry/rigid3.h"

namespace treeline::drift {

// With (translation, rotation) zero-mean of `covariance`, as
// geometry::PoseCovariance has it, the truth is
//   (Exp(rotation) * rotation of the pose, translation of the pose +
//   translation), both expressed in the world.
struct GaussianPose {
  geometry::Rigid3 world_from_camera;
  geometry::PoseCovariance covariance{};
};

// diag(v, v, v, r, r, r).
geometry::PoseCovariance Diagonal(double position_variance_m2,
                                  double rotation_variance_rad2);

geometry::PoseCovariance Sum(const geometry::PoseCovariance& a,
                             const geometry::PoseCovariance& b);

geometry::PoseCovariance Scaled(const geometry::PoseCovariance& covariance,
                                double factor);

// Whether it is finite, and symmetric and positive semidefinite to rounding.
bool IsCovariance(const geometry::PoseCovariance& covariance);

// The covariance of the same camera after it moved by `moved_in_world` (m): an
// error of rotation at the start is an error of position at the end.
//   F * covariance * F^T,  F = [I, -[moved]x; 0, I]
geometry::PoseCovariance Transported(const geometry::PoseCovariance& covariance,
                                     geometry::Vec3 moved_in_world);

// How one pose differs from another, in the world.
struct PoseDelta {
  geometry::Vec3 translation_m;
  geometry::Vec3 rotation_rad;  // axis times angle
};

// What takes a to b: (t_b - t_a, Log(R_b * inverse(R_a))).
PoseDelta Difference(const geometry::Rigid3& a_world_from_camera,
                     const geometry::Rigid3& b_world_from_camera);

// The pose moved by what Difference gives.
geometry::Rigid3 Moved(const geometry::Rigid3& world_from_camera,
                       const PoseDelta& delta);

// r^T (A + B)^-1 r of the difference r; infinite if A + B is not positive
// definite.
double SquaredDistance(const GaussianPose& a, const GaussianPose& b);

// Both as one: each counts by its information.
//   gain K = A (A + B)^-1, pose = a moved by K r, covariance = A - K A
// A + B is positive definite.
GaussianPose Fused(const GaussianPose& a, const GaussianPose& b);

// The largest standard deviation along an axis of the world.
double PositionSigma_m(const geometry::PoseCovariance& covariance);

// The largest standard deviation about an axis of the world.
double RotationSigma_rad(const geometry::PoseCovariance& covariance);

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_GAUSSIAN_POSE_H_

#include "server/core/pose/turn_estimate.h"

#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Core"

namespace treeline::pose {
namespace {

// Moved, turned (camera frame), turn rate.
constexpr int kUnknowns = 9;
using Matrix9 = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Vector9 = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kIterations = 8;
// The first steps see further, in inlier distances.
constexpr double kFirstReach = 3;
constexpr int kFirstSteps = 3;

class TurnFit {
 public:
  TurnFit(std::span<const TimedRay> rays, const geometry::Rigid3& start,
          const TurnOptions& options)
      : rays_(rays), options_(options), camera_from_world_(start.Inverse()) {}

  std::optional<TurnEstimate> Run() {
    for (int i = 0; i < kIterations; ++i) {
      if (!Step(i < kFirstSteps ? kFirstReach : 1)) return std::nullopt;
    }
    Sum(1);
    if (inliers_ < options_.min_inliers) return std::nullopt;
    return Estimate();
  }

 private:
  // Adds what ray says, `reach` times as far as at the end.
  void Add(const TimedRay& ray, double reach) {
    const geometry::Vec3 at_stamp = camera_from_world_ * ray.point_in_world;
    const geometry::Vec3 p =
        geometry::Rotation3::FromAxisAngle(-ray.delay_s * turn_rate_rad_s_) *
        at_stamp;
    if (!(p.z > 0)) return;
    const Eigen::Vector2d residual(p.x / p.z - ray.ray.x,
                                   p.y / p.z - ray.ray.y);
    const double squared = residual.squaredNorm();
    const double within = reach * options_.inlier_distance;
    if (squared > within * within) return;
    ++inliers_;
    Eigen::Matrix<double, 2, 3> project;
    project << 1 / p.z, 0, -p.x / (p.z * p.z),  //
        0, 1 / p.z, -p.y / (p.z * p.z);
    // Of small turns r: p + r x p.
    Eigen::Matrix3d cross;
    cross << 0, p.z, -p.y,  //
        -p.z, 0, p.x,       //
        p.y, -p.x, 0;
    Eigen::Matrix<double, 2, kUnknowns> slope;
    slope << project, project * cross, -ray.delay_s * project * cross;
    const double scale = reach * options_.robust_scale;
    const double shrink = 1 / (1 + squared / (scale * scale));
    const double weight =
        shrink * shrink / (options_.robust_scale * options_.robust_scale);
    information_ += weight * slope.transpose() * slope;
    gradient_ += weight * slope.transpose() * residual;
  }

  void Sum(double reach) {
    information_.setZero();
    gradient_.setZero();
    inliers_ = 0;
    for (const TimedRay& ray : rays_) Add(ray, reach);
    const double prior =
        1 / (options_.prior_sigma_rad_s * options_.prior_sigma_rad_s);
    information_.bottomRightCorner<3, 3>() +=
        prior * Eigen::Matrix3d::Identity();
    gradient_.tail<3>() +=
        prior * Eigen::Vector3d(turn_rate_rad_s_.x, turn_rate_rad_s_.y,
                                turn_rate_rad_s_.z);
  }

  bool Step(double reach) {
    Sum(reach);
    if (inliers_ < options_.min_inliers) return false;
    const Eigen::LDLT<Matrix9> factors(information_);
    if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-14)) {
      return false;
    }
    const Vector9 step = -factors.solve(gradient_);
    if (!step.allFinite()) return false;
    const geometry::Rotation3 turn =
        geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]});
    camera_from_world_ = {
        geometry::Normalized(turn * camera_from_world_.rotation),
        turn * camera_from_world_.translation +
            geometry::Vec3{step[0], step[1], step[2]}};
    turn_rate_rad_s_ =
        turn_rate_rad_s_ + geometry::Vec3{step[6], step[7], step[8]};
    return true;
  }

  TurnEstimate Estimate() const {
    TurnEstimate estimate;
    estimate.turn_rate_rad_s = turn_rate_rad_s_;
    estimate.inliers = inliers_;
    const Matrix9 covariance = information_.ldlt().solve(Matrix9::Identity());
    const Eigen::Matrix3d of_turn = covariance.bottomRightCorner<3, 3>();
    const Eigen::Vector3d rate(turn_rate_rad_s_.x, turn_rate_rad_s_.y,
                               turn_rate_rad_s_.z);
    estimate.sigmas =
        std::sqrt(std::max(0.0, rate.dot(of_turn.ldlt().solve(rate))));
    // The pose follows the turn rate by the information they share.
    const Matrix6 of_pose = information_.topLeftCorner<6, 6>();
    const Eigen::Matrix<double, 6, 3> follows =
        of_pose.ldlt().solve(information_.topRightCorner<6, 3>());
    const Matrix6 in_camera = follows * of_turn * follows.transpose();
    const geometry::Mat3 r = camera_from_world_.rotation.Inverse().Matrix();
    Matrix6 turn = Matrix6::Zero();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) turn(i, j) = turn(3 + i, 3 + j) = r(i, j);
    }
    const Matrix6 in_world = turn * in_camera * turn.transpose();
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        estimate.added_covariance[static_cast<size_t>(6 * i + j)] =
            0.5 * (in_world(i, j) + in_world(j, i));
      }
    }
    return estimate;
  }

  const std::span<const TimedRay> rays_;
  const TurnOptions& options_;
  geometry::Rigid3 camera_from_world_;
  geometry::Vec3 turn_rate_rad_s_;
  Matrix9 information_ = Matrix9::Zero();
  Vector9 gradient_ = Vector9::Zero();
  int inliers_ = 0;
};

}  // namespace

std::optional<TurnEstimate> EstimateTurn(
    std::span<const TimedRay> rays, const geometry::Rigid3& world_from_camera,
    const TurnOptions& options) {
  return TurnFit(rays, world_from_camera, options).Run();
}

}  // namespace treeline::pose

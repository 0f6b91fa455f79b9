#include "server/core/pose/focal_estimate.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "server/core/pose/parameters.h"
#include "server/core/pose/point_refinement.h"
#include "server/core/pose/reprojection.h"
#include "server/core/pose/robust_refinement.h"

namespace treeline::pose {
namespace {

// What is sought. A step of it is (v, w, ...): of a point p in the camera
// v + w x p, and then of the logarithms.
struct Unknowns {
  geometry::Rigid3 camera_from_world;
  double log_focal = 0;
  double log_depth = 0;  // the true depth by the stated one
  Eigen::Vector3d lens = Eigen::Vector3d::Zero();  // offset, and distortion
};
constexpr int kFocalIndex = 6;
// Of points.
constexpr int kDepthIndex = 7;
// Of rays.
constexpr int kLensIndex = 7;
constexpr int kLensUnknowns = 3;

template <int kUnknowns>
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
template <int kUnknowns>
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// Normal equations of a step.
template <int kUnknowns>
struct Sum {
  Matrix<kUnknowns> hessian = Matrix<kUnknowns>::Zero();
  Vector<kUnknowns> gradient = Vector<kUnknowns>::Zero();
  double value = 0;
  double weights = 0;
};

// Geman-McClure's weight of a squared distance, in [0, 1].
double RobustWeight(double squared, double robust_scale) {
  const double root =
      robust_scale * robust_scale / (robust_scale * robust_scale + squared);
  return root * root;
}

double SquaredReach(double robust_scale) {
  return kRobustReach * kRobustReach * robust_scale * robust_scale;
}

// Reprojection errors. Of 7 unknowns, or 10: with the lens.
template <int kCount>
class RayResiduals {
 public:
  static constexpr int kUnknowns = kCount;
  static constexpr int kOfOne = 2;
  static constexpr bool kHasLens = kCount > kLensIndex;

  // `prior` counts with the lens.
  explicit RayResiduals(const RayPredictions& scene,
                        const LensPrior& prior = {})
      : scene_(scene), prior_(prior) {}

  Sum<kUnknowns> SumAt(const Unknowns& at, double robust_scale) const {
    const CameraFromWorld to_camera(at.camera_from_world);
    const double scale = std::exp(at.log_focal);
    Sum<kUnknowns> sum;
    for (size_t i = 0; i < scene_.size(); ++i) {
      const geometry::Vec3 p = to_camera * scene_.at(i, 0).mean_in_world;
      if (p.z < kMinPointDepth) continue;
      const Eigen::Vector2d residual = ResidualAt(at, scale, p, i);
      const double squared = residual.squaredNorm();
      if (!(squared <= SquaredReach(robust_scale))) continue;
      const double robust = RobustWeight(squared, robust_scale);
      // The prediction's spread, as if it were the same in all directions.
      const double spread = scene_.at(i, 0).covariance[0] / (p.z * p.z);
      const double weight =
          robust /
          (scene_.ray_sigma[i] * scene_.ray_sigma[i] + scale * scale * spread);
      const Derivatives j = DerivativesAt(p, scale, at.lens.z());
      sum.hessian.noalias() += weight * j.transpose() * j;
      sum.gradient.noalias() += weight * j.transpose() * residual;
      sum.value += weight * squared;
      sum.weights += robust;
    }
    if constexpr (kHasLens) {
      const Eigen::Array3d sigma{prior_.offset, prior_.offset, prior_.radial};
      const Eigen::Vector3d prior = 1 / (sigma * sigma);
      sum.hessian.diagonal().template tail<kLensUnknowns>() += prior;
      sum.gradient.template tail<kLensUnknowns>() +=
          prior.cwiseProduct(at.lens);
    }
    return sum;
  }

 private:
  using Derivatives = Eigen::Matrix<double, kOfOne, kUnknowns>;

  Eigen::Vector2d ResidualAt(const Unknowns& at, double scale, geometry::Vec3 p,
                             size_t i) const {
    const Eigen::Vector2d image{p.x / p.z, p.y / p.z};
    const Eigen::Vector2d ray{scene_.ray[i].x, scene_.ray[i].y};
    if constexpr (!kHasLens) return scale * image - ray;
    return scale * (1 + at.lens.z() * image.squaredNorm()) * image +
           at.lens.head<2>() - ray;
  }

  // Of the point's image under the sought focal length, in units of the rays.
  static Derivatives DerivativesAt(geometry::Vec3 p, double scale,
                                   double radial) {
    const double iz = 1 / p.z;
    const double x = p.x * iz;
    const double y = p.y * iz;
    Eigen::Matrix<double, kOfOne, kLensIndex> j;
    j << iz, 0, -x * iz, -x * y, 1 + x * x, -y, x,  //
        0, iz, -y * iz, -1 - y * y, x * y, x, y;
    if constexpr (!kHasLens) return scale * j;
    const Eigen::Vector2d image{x, y};
    const double distortion = 1 + radial * image.squaredNorm();
    Derivatives all;
    all.template leftCols<kFocalIndex>() =
        scale *
        (distortion * Eigen::Matrix2d::Identity() +
         2 * radial * image * image.transpose()) *
        j.leftCols<kFocalIndex>();
    all.col(kFocalIndex) = scale * distortion * image;
    all.template middleCols<2>(kLensIndex).setIdentity();
    all.col(kUnknowns - 1) = scale * image.squaredNorm() * image;
    return all;
  }

  const RayPredictions& scene_;
  const LensPrior prior_;
};

// Distances in space of measured points and their nearest predictions.
class PointResiduals {
 public:
  static constexpr int kUnknowns = 8;
  static constexpr int kOfOne = 3;

  explicit PointResiduals(const PointPredictions& scene) : scene_(scene) {}

  Sum<kUnknowns> SumAt(const Unknowns& at, double robust_scale) const {
    const CameraFromWorld to_camera(at.camera_from_world);
    const CameraFromWorld to_world(at.camera_from_world.Inverse());
    const double depth = std::exp(at.log_depth);
    const double across = depth * std::exp(-at.log_focal);
    Sum<kUnknowns> sum;
    for (size_t i = 0; i < scene_.size(); ++i) {
      const geometry::Vec3 stated = scene_.point_in_camera[i];
      const geometry::Vec3 x{across * stated.x, across * stated.y,
                             depth * stated.z};
      const geometry::Vec3 in_world = to_world * x;
      const NearestPrediction nearest =
          NearestOf(scene_.per_sample, [&](int k) {
            return geometry::SquaredNorm(in_world -
                                         scene_.at(i, k).mean_in_world);
          });
      if (!(nearest.squared_distance <= SquaredReach(robust_scale))) continue;
      const ScenePrediction& prediction = scene_.at(i, nearest.k);
      const geometry::Vec3 p = to_camera * prediction.mean_in_world;
      const Eigen::Vector3d measured{x.x, x.y, x.z};
      const Eigen::Vector3d residual =
          Eigen::Vector3d{p.x, p.y, p.z} - measured;
      const double robust =
          RobustWeight(nearest.squared_distance, robust_scale);
      const Eigen::Matrix3d information =
          robust * Information(prediction, measured, scene_.depth_sigma_m[i]);
      const Derivatives j = DerivativesAt(p, measured);
      const Derivatives weighted = information * j;
      sum.hessian.noalias() += j.transpose() * weighted;
      sum.gradient.noalias() += weighted.transpose() * residual;
      sum.value += residual.dot(information * residual);
      sum.weights += robust;
    }
    const double prior = 1 / (kDepthScaleSigma * kDepthScaleSigma);
    sum.hessian(kDepthIndex, kDepthIndex) += prior;
    sum.gradient[kDepthIndex] += prior * at.log_depth;
    return sum;
  }

 private:
  using Derivatives = Eigen::Matrix<double, kOfOne, kUnknowns>;

  // Of the prediction less the measured point.
  static Derivatives DerivativesAt(geometry::Vec3 p,
                                   const Eigen::Vector3d& measured) {
    Derivatives j;
    j << 1, 0, 0, 0, p.z, -p.y, measured.x(), -measured.x(),  //
        0, 1, 0, -p.z, 0, p.x, measured.y(), -measured.y(),   //
        0, 0, 1, p.y, -p.x, 0, 0, -measured.z();
    return j;
  }

  // (s^2 I + d^2 v v^T)^-1: the prediction's spread s, as if it were the same
  // in all directions, and the depth noise d along the viewing ray v.
  static Eigen::Matrix3d Information(const ScenePrediction& prediction,
                                     const Eigen::Vector3d& measured,
                                     double depth_sigma_m) {
    const double model = PointRefinementOptions{}.model_sigma_m;
    const double spread = (prediction.covariance[0] + prediction.covariance[3] +
                           prediction.covariance[5]) /
                              3 +
                          model * model;
    const double along = depth_sigma_m * depth_sigma_m;
    return (Eigen::Matrix3d::Identity() -
            measured * measured.transpose() *
                (along / ((spread + along) * measured.squaredNorm()))) /
           spread;
  }

  const PointPredictions& scene_;
};

// False: no sensible step.
template <int kUnknowns>
bool Move(const Vector<kUnknowns>& step, Unknowns& at) {
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]});
  at.camera_from_world = {
      geometry::Normalized(turn * at.camera_from_world.rotation),
      turn * at.camera_from_world.translation +
          geometry::Vec3{step[0], step[1], step[2]}};
  at.log_focal += step[kFocalIndex];
  if constexpr (kUnknowns == kDepthIndex + 1) at.log_depth += step[kDepthIndex];
  if constexpr (kUnknowns == kLensIndex + kLensUnknowns) {
    at.lens += step.template tail<kLensUnknowns>();
  }
  return geometry::IsFinite(at.camera_from_world) &&
         std::isfinite(at.log_depth) &&
         std::abs(at.log_focal) < kMaxLogFocalScale;
}

// The robust scale starts `initial_scale` times as large and shrinks.
struct Descent {
  int iterations = 1;
  double robust_scale = 1;
  double initial_scale = 1;
  double min_rcond = 0;
};

template <int kUnknowns>
struct Minimum {
  Unknowns at;
  Matrix<kUnknowns> hessian;
  double variance = 1;  // of a residual, in units of what is stated of it

  Matrix<kUnknowns> Covariance() const {
    return variance * hessian.ldlt().solve(Matrix<kUnknowns>::Identity());
  }
};

template <typename Residuals>
std::optional<Minimum<Residuals::kUnknowns>> Minimize(
    const Residuals& residuals, const geometry::Rigid3& world_from_camera,
    const Descent& descent) {
  constexpr int kUnknowns = Residuals::kUnknowns;
  Minimum<kUnknowns> minimum{
      .at = {.camera_from_world = world_from_camera.Inverse()}, .hessian = {}};
  Unknowns& at = minimum.at;
  for (int i = 0; i < descent.iterations; ++i) {
    const double progress = std::min(1.0, 2.0 * i / descent.iterations);
    const Sum<kUnknowns> sum =
        residuals.SumAt(at, descent.robust_scale *
                                std::pow(descent.initial_scale, 1 - progress));
    if (sum.weights < kMinRobustWeights) return std::nullopt;
    const Eigen::LDLT<Matrix<kUnknowns>> factors(sum.hessian);
    if (factors.info() != Eigen::Success ||
        !(factors.rcond() > descent.min_rcond)) {
      return std::nullopt;
    }
    const Vector<kUnknowns> step = -factors.solve(sum.gradient);
    if (!Move<kUnknowns>(step, at)) return std::nullopt;
    const double degrees =
        std::max(1.0, Residuals::kOfOne * sum.weights - kUnknowns);
    minimum.hessian = sum.hessian;
    minimum.variance = std::max(1.0, sum.value / degrees);
  }
  return minimum;
}

// `covariance` is of a step (v, w); the camera in the world moves by -R v and
// turns by -R w.
geometry::PoseCovariance InWorld(const Eigen::Matrix<double, 6, 6>& covariance,
                                 const geometry::Rigid3& camera_from_world) {
  const geometry::Mat3 r = camera_from_world.Inverse().rotation.Matrix();
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
          r.m.data());
  turn.bottomRightCorner<3, 3>() = turn.topLeftCorner<3, 3>();
  geometry::PoseCovariance result{};
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(result.data()) =
      turn * covariance * turn.transpose();
  return result;
}

// What not to know the camera adds to the covariance of a pose of rays.
template <int kUnknowns>
geometry::PoseCovariance AddedBy(const Minimum<kUnknowns>& minimum) {
  const Matrix<6> with_camera =
      minimum.variance *
      minimum.hessian.template topLeftCorner<6, 6>().ldlt().solve(
          Matrix<6>::Identity());
  return InWorld(
      minimum.Covariance().template topLeftCorner<6, 6>() - with_camera,
      minimum.at.camera_from_world);
}

template <int kUnknowns>
std::optional<FocalEstimate> FocalOf(
    const std::optional<Minimum<kUnknowns>>& minimum) {
  if (!minimum) return std::nullopt;
  const double variance =
      minimum->variance * minimum->hessian.ldlt().solve(Vector<kUnknowns>::Unit(
                              kFocalIndex))[kFocalIndex];
  // Rounding may leave nothing of it where the focal length is hardly told.
  if (!(variance > 0)) return std::nullopt;
  return FocalEstimate{.scale = std::exp(minimum->at.log_focal),
                       .sigma = std::sqrt(variance)};
}

Descent RayDescent(double robust_scale) {
  return {.iterations = kFocalIterations,
          .robust_scale = robust_scale,
          .initial_scale = kInitialFocalRobustScale,
          .min_rcond = kMinRayRcond};
}

}  // namespace

std::optional<FocalEstimate> EstimateFocal(
    const RayPredictions& scene, const geometry::Rigid3& world_from_camera,
    double robust_scale) {
  const auto minimum = Minimize(RayResiduals<7>(scene), world_from_camera,
                                RayDescent(robust_scale));
  std::optional<FocalEstimate> estimate = FocalOf(minimum);
  if (estimate) estimate->added = AddedBy(*minimum);
  return estimate;
}

std::optional<LensEstimate> EstimateLens(
    const RayPredictions& scene, const geometry::Rigid3& world_from_camera,
    double robust_scale, const LensPrior& prior) {
  constexpr int kUnknowns = kLensIndex + kLensUnknowns;
  const auto minimum = Minimize(RayResiduals<kUnknowns>(scene, prior),
                                world_from_camera, RayDescent(robust_scale));
  const std::optional<FocalEstimate> focal = FocalOf(minimum);
  if (!focal) return std::nullopt;
  const Matrix<kUnknowns> covariance = minimum->Covariance();
  const Eigen::Vector3d& lens = minimum->at.lens;
  LensEstimate estimate{.focal = *focal,
                        .offset_x = lens.x(),
                        .offset_y = lens.y(),
                        .radial = lens.z(),
                        .added = AddedBy(*minimum)};
  Eigen::Map<Eigen::Matrix3d>(estimate.covariance.data()) =
      covariance.bottomRightCorner<kLensUnknowns, kLensUnknowns>();
  return estimate;
}

std::optional<FocalEstimate> EstimateFocal(
    const PointPredictions& scene, const geometry::Rigid3& world_from_camera) {
  std::optional<FocalEstimate> estimate =
      FocalOf(Minimize(PointResiduals(scene), world_from_camera,
                       {.iterations = kPointFocalIterations,
                        .robust_scale = PointRefinementOptions{}.robust_scale_m,
                        .initial_scale = kInitialPointFocalRobustScale,
                        .min_rcond = kMinPointRcond}));
  if (estimate) estimate->sigma = std::hypot(estimate->sigma, kPointFocalBias);
  return estimate;
}

}  // namespace treeline::pose

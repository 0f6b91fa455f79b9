#include "server/core/keyframes/depth_scale.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "common/geometry/rigid3.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

// A keyframe's point with its normal, and what was measured there, all in the
// camera as the view has it.
struct Surface {
  geometry::Vec3 point;
  geometry::Vec3 normal;
  geometry::Vec3 measured;
  double variance = 0;
};

class Surfaces {
 public:
  Surfaces(const SurfacePoints& points, const PinholeView& view)
      : points_(points), view_(view) {}

  size_t size() const { return points_.size(); }

  // nullopt: it is seen at a flat angle, or fills up a block.
  std::optional<Surface> At(size_t i) const {
    Surface surface;
    surface.normal = Rotate(points_.nx[i], points_.ny[i], points_.nz[i]);
    surface.measured = {points_.measured_x[i], points_.measured_y[i],
                        points_.measured_z[i]};
    const double facing = -geometry::Dot(surface.normal, surface.measured);
    if (!(facing > 0 &&
          facing * facing > kMinScaleFacing * kMinScaleFacing *
                                geometry::SquaredNorm(surface.measured))) {
      return std::nullopt;
    }
    surface.point = Rotate(points_.x[i] - view_.position[0],
                           points_.y[i] - view_.position[1],
                           points_.z[i] - view_.position[2]);
    surface.variance = points_.variance[i];
    return surface;
  }

 private:
  geometry::Vec3 Rotate(float x, float y, float z) const {
    const auto& r = view_.camera_from_world_rotation;
    return {r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z,
            r[6] * x + r[7] * y + r[8] * z};
  }

  const SurfacePoints& points_;
  const PinholeView& view_;
};

std::vector<Surface> AllOf(const Surfaces& surfaces) {
  std::vector<Surface> all;
  all.reserve(surfaces.size());
  for (size_t i = 0; i < surfaces.size(); ++i) {
    if (const auto surface = surfaces.At(i)) all.push_back(*surface);
  }
  return all;
}

// Of the step of the camera and of log(scale).
struct Sums {
  Matrix7 hessian = Matrix7::Zero();
  Vector7 gradient = Vector7::Zero();
};

double DistanceOf(const Surface& surface, double scale) {
  return geometry::Dot(surface.normal,
                       surface.point - scale * surface.measured);
}

// Geman-McClure's, at a scale of `width` standard deviations.
double WeightOf(const Surface& surface, double distance, double width) {
  const double reach2 = width * width * surface.variance;
  const double root = reach2 / (reach2 + distance * distance);
  return root * root / surface.variance;
}

Sums SumAt(const std::vector<Surface>& surfaces, double scale, double width) {
  Sums sums;
  for (const Surface& surface : surfaces) {
    const double distance = DistanceOf(surface, scale);
    const geometry::Vec3 turn = geometry::Cross(surface.point, surface.normal);
    Vector7 j;
    j << surface.normal.x, surface.normal.y, surface.normal.z, turn.x, turn.y,
        turn.z, -scale * geometry::Dot(surface.normal, surface.measured);
    const double weight = WeightOf(surface, distance, width);
    sums.hessian.noalias() += weight * j * j.transpose();
    sums.gradient.noalias() += weight * distance * j;
  }
  return sums;
}

void Move(const Vector6& step, std::vector<Surface>& surfaces) {
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]});
  for (Surface& surface : surfaces) {
    surface.point =
        turn * surface.point + geometry::Vec3{step[0], step[1], step[2]};
    surface.normal = turn * surface.normal;
  }
}

// That which puts half of the measured points before their surfaces, and half
// behind them.
double MiddleScale(const std::vector<Surface>& surfaces) {
  std::vector<double> scales;
  scales.reserve(surfaces.size());
  for (const Surface& surface : surfaces) {
    scales.push_back(geometry::Dot(surface.normal, surface.point) /
                     geometry::Dot(surface.normal, surface.measured));
  }
  const auto middle =
      scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
  std::nth_element(scales.begin(), middle, scales.end());
  return *middle;
}

double Agreement(const std::vector<Surface>& surfaces, double scale) {
  int lying = 0;
  for (const Surface& surface : surfaces) {
    lying += std::abs(DistanceOf(surface, scale)) <=
             kScaleAgreement * std::sqrt(surface.variance);
  }
  return static_cast<double>(lying) / static_cast<double>(surfaces.size());
}

}  // namespace

std::optional<DepthScale> EstimateDepthScale(
    const SurfacePoints& points, const PinholeView& view,
    const PoseInformation& information) {
  std::vector<Surface> surfaces = AllOf(Surfaces(points, view));
  if (static_cast<int>(surfaces.size()) < kMinScalePoints) return std::nullopt;
  const Matrix6 prior = Eigen::Map<const Matrix6>(information.data());
  double log_scale = std::log(std::max(1e-6, MiddleScale(surfaces)));
  Vector6 moved = Vector6::Zero();
  double variance = 0;
  for (int i = 0; i < kScaleIterations; ++i) {
    if (!(std::abs(log_scale) <= kMaxLogDepthScale)) return std::nullopt;
    const double width =
        2 * std::max(1.0, kInitialScaleWidth / static_cast<double>(i + 1));
    Sums sums = SumAt(surfaces, std::exp(log_scale), width);
    sums.hessian.topLeftCorner<6, 6>() += prior;
    sums.gradient.head<6>() += prior * moved;
    const Eigen::LDLT<Matrix7> factors(sums.hessian);
    if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-12)) {
      return std::nullopt;
    }
    const Vector7 step = -factors.solve(sums.gradient);
    if (!step.allFinite()) return std::nullopt;
    Move(step.head<6>(), surfaces);
    moved += step.head<6>();
    log_scale += step[6];
    variance = kCorrelatedPoints * factors.solve(Vector7::Unit(6))[6];
  }
  if (!(std::abs(log_scale) <= kMaxLogDepthScale)) return std::nullopt;
  const double scale = std::exp(log_scale);
  return DepthScale{.scale = scale,
                    .sigma = std::sqrt(variance),
                    .points = static_cast<int>(surfaces.size()),
                    .agreement = Agreement(surfaces, scale)};
}

std::optional<DepthScale> DepthScaleStep(const SurfacePoints& points,
                                         const PinholeView& view,
                                         const PoseInformation& information) {
  // The pose is already where picture and surfaces want it: of the step's
  // equations only those of the scale are summed up, every query being asked.
  const Surfaces surfaces(points, view);
  Vector6 with_pose = Vector6::Zero();
  double hessian = 0;
  double gradient = 0;
  int used = 0;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    const auto surface = surfaces.At(i);
    if (!surface) continue;
    ++used;
    const double distance = DistanceOf(*surface, 1);
    const double by_scale = -geometry::Dot(surface->normal, surface->measured);
    const double weighted = WeightOf(*surface, distance, 2) * by_scale;
    const geometry::Vec3 turn =
        geometry::Cross(surface->point, surface->normal);
    with_pose[0] += weighted * surface->normal.x;
    with_pose[1] += weighted * surface->normal.y;
    with_pose[2] += weighted * surface->normal.z;
    with_pose[3] += weighted * turn.x;
    with_pose[4] += weighted * turn.y;
    with_pose[5] += weighted * turn.z;
    hessian += weighted * by_scale;
    gradient += weighted * distance;
  }
  if (used < kMinScalePoints) return std::nullopt;
  const Eigen::LDLT<Matrix6> factors(
      Matrix6(Eigen::Map<const Matrix6>(information.data())));
  if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-12)) {
    return std::nullopt;
  }
  // What is left of it once the pose may follow.
  const double known = hessian - with_pose.dot(factors.solve(with_pose));
  const double log_scale = -gradient / known;
  if (!(known > 0) || !(std::abs(log_scale) < 1)) return std::nullopt;
  return DepthScale{.scale = std::exp(log_scale),
                    .sigma = std::sqrt(kCorrelatedPoints / known),
                    .points = used};
}

}  // namespace treeline::keyframes

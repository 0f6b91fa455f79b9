#include "server/core/pose/rigid_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "server/core/pose/rigid_terms.h"

namespace treeline::pose {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kInitialScale = 3;

constexpr double kLeastDamping = 1e-4;
constexpr double kDampingFactor = 10;
constexpr int kDampedTries = 5;

struct NearestPrediction {
  int k = 0;
  double squared_distance = 0;
};

NearestPrediction Nearest(const ScenePredictions& scene, size_t i,
                          geometry::Vec3 point_in_world) {
  NearestPrediction nearest;
  nearest.squared_distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < scene.per_point; ++k) {
    const double distance =
        geometry::SquaredNorm(point_in_world - scene.at(i, k).mean_in_world);
    if (distance < nearest.squared_distance) nearest = {k, distance};
  }
  return nearest;
}

// S + s^2 v v^T + model^2 I with v a unit vector in the world.
Symmetric3 Covariance(const ScenePrediction& prediction, geometry::Vec3 ray,
                      double depth_sigma_m, double model_sigma_m) {
  Symmetric3 c = prediction.covariance;
  const double s = depth_sigma_m * depth_sigma_m;
  const double m = model_sigma_m * model_sigma_m;
  c[0] += s * ray.x * ray.x + m;
  c[1] += s * ray.x * ray.y;
  c[2] += s * ray.x * ray.z;
  c[3] += s * ray.y * ray.y + m;
  c[4] += s * ray.y * ray.z;
  c[5] += s * ray.z * ray.z + m;
  return c;
}

// What one point adds to the sum, at the pose where its prediction, and the
// weight of it, were chosen.
struct Term {
  size_t point = 0;
  geometry::Vec3 mean_in_world;
  Symmetric3 information{};  // weighted
};

// The sum and its normal equations.
struct WeightedSum {
  NormalEquations equations;
  double value = 0;
  double weights = 0;
  double line_weights = 0;  // the part of points on lines
  std::vector<Term> terms;
};

// Adds terms up at one pose and one scale of the robust loss.
class SumAt {
 public:
  SumAt(const ScenePredictions& scene, const RefinementOptions& options,
        const geometry::Rigid3& pose, double scale2)
      : scene_(scene), options_(options), pose_(pose), scale2_(scale2) {}

  WeightedSum Compute() const {
    WeightedSum sum;
    const size_t end = std::min(scene_.size(), options_.max_points);
    for (size_t i = 0; i < end; ++i) AddPoint(i, sum);
    return sum;
  }

 private:
  struct Match {
    int k = -1;  // none
    double squared_distance = std::numeric_limits<double>::infinity();
    double score = std::numeric_limits<double>::infinity();
    Symmetric3 information{};
  };

  double SquaredDistance(geometry::Vec3 residual,
                         geometry::Vec3 direction) const {
    const double squared = geometry::SquaredNorm(residual);
    if (direction == geometry::Vec3{}) return squared;
    const double slide = geometry::Dot(residual, direction);
    return std::abs(slide) <= options_.max_slide_m
               ? squared - slide * slide
               : std::numeric_limits<double>::infinity();
  }

  Symmetric3 InformationOf(size_t i, int k, geometry::Vec3 rotated) const {
    return Inverse(Covariance(scene_.at(i, k), geometry::Normalized(rotated),
                              scene_.depth_sigma_m[i], options_.model_sigma_m));
  }

  // direction is zero, or that of the point's line in the world.
  Match MatchOf(size_t i, geometry::Vec3 rotated,
                geometry::Vec3 direction) const {
    Match best;
    for (int k = 0; k < scene_.per_point; ++k) {
      const geometry::Vec3 residual =
          rotated + pose_.translation - scene_.at(i, k).mean_in_world;
      Match match{k, SquaredDistance(residual, direction), 0, {}};
      if (match.squared_distance > 9 * scale2_) continue;
      match.score = match.squared_distance;
      if (options_.likeliest_prediction) {
        match.information = InformationOf(i, k, rotated);
        const Symmetric3 known = direction == geometry::Vec3{}
                                     ? match.information
                                     : AcrossLine(match.information, direction);
        match.score = QuadraticForm(known, residual) -
                      std::log(Determinant(match.information));
      }
      if (match.score < best.score) best = match;
    }
    if (best.k >= 0 && !options_.likeliest_prediction) {
      best.information = InformationOf(i, best.k, rotated);
    }
    return best;
  }

  void AddPoint(size_t i, WeightedSum& sum) const {
    const geometry::Vec3 rotated = pose_.rotation * scene_.point_in_camera[i];
    const bool on_line = scene_.is_on_line(i);
    const geometry::Vec3 direction =
        on_line ? pose_.rotation * scene_.line_direction_in_camera[i]
                : geometry::Vec3{};
    const Match match = MatchOf(i, rotated, direction);
    if (match.k < 0) return;
    const double robust = scale2_ * scale2_ /
                          ((scale2_ + match.squared_distance) *
                           (scale2_ + match.squared_distance));
    Symmetric3 w = match.information;
    for (double& entry : w) entry *= robust;
    const geometry::Vec3 mean = scene_.at(i, match.k).mean_in_world;
    geometry::Vec3 x = rotated;
    geometry::Vec3 residual = rotated + pose_.translation - mean;
    if (options_.levenberg_marquardt) sum.terms.push_back({i, mean, w});
    if (on_line) {
      const geometry::Vec3 along =
          ClosestOnLine(w, residual, direction) * direction;
      x = x + along;
      residual = residual + along;
      w = AcrossLine(w, direction);
      sum.line_weights += robust;
    }
    sum.equations.Add(w, x, residual);
    sum.value += QuadraticForm(w, residual);
    sum.weights += robust;
  }

  const ScenePredictions& scene_;
  const RefinementOptions& options_;
  const geometry::Rigid3& pose_;
  const double scale2_;
};

// The sum of terms as they are, at another pose.
double ValueAt(const ScenePredictions& scene, const std::vector<Term>& terms,
               const geometry::Rigid3& pose) {
  double value = 0;
  for (const Term& term : terms) {
    const geometry::Vec3 residual =
        pose * scene.point_in_camera[term.point] - term.mean_in_world;
    value += QuadraticForm(
        scene.is_on_line(term.point)
            ? AcrossLine(
                  term.information,
                  pose.rotation * scene.line_direction_in_camera[term.point])
            : term.information,
        residual);
  }
  return value;
}

geometry::Rigid3 Moved(const geometry::Rigid3& pose, const Vector6& step) {
  return {geometry::Normalized(
              geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]}) *
              pose.rotation),
          pose.translation + geometry::Vec3{step[0], step[1], step[2]}};
}

Matrix6 Hessian(const NormalEquations& equations) {
  Matrix6 h = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(
      equations.hessian.data());
  h.triangularView<Eigen::StrictlyLower>() = h.transpose();
  return h;
}

// One step from `pose`; damping carries over to the next one. nullopt: the
// equations are singular.
std::optional<geometry::Rigid3> Step(const ScenePredictions& scene,
                                     const WeightedSum& sum, const Matrix6& h,
                                     bool levenberg_marquardt,
                                     const geometry::Rigid3& pose,
                                     double& damping) {
  const Eigen::Map<const Vector6> g(sum.equations.gradient.data());
  if (sum.weights < 3) return std::nullopt;
  for (int attempt = 0; attempt < kDampedTries; ++attempt) {
    Matrix6 damped = h;
    if (levenberg_marquardt) damped.diagonal() *= 1 + damping;
    const Eigen::LDLT<Matrix6> factors(damped);
    if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-12)) {
      return std::nullopt;
    }
    const geometry::Rigid3 moved = Moved(pose, -factors.solve(g));
    if (!levenberg_marquardt) return moved;
    if (ValueAt(scene, sum.terms, moved) <= sum.value) {
      damping = std::max(kLeastDamping, damping / kDampingFactor);
      return moved;
    }
    damping *= kDampingFactor;
  }
  return pose;
}

}  // namespace

std::optional<RefinedPose> RefineRigid(
    const ScenePredictions& scene, const geometry::Rigid3& world_from_camera,
    const RefinementOptions& options) {
  RefinedPose refined;
  geometry::Rigid3 pose = world_from_camera;
  Matrix6 h;
  WeightedSum sum;
  double damping = kLeastDamping;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const double progress = std::min(
        1.0, static_cast<double>(iteration) / (0.5 * options.iterations));
    const double scale =
        options.robust_scale_m * std::pow(kInitialScale, 1 - progress);
    sum = SumAt(scene, options, pose, scale * scale).Compute();
    h = Hessian(sum.equations);
    const std::optional<geometry::Rigid3> next =
        Step(scene, sum, h, options.levenberg_marquardt, pose, damping);
    if (!next) return std::nullopt;
    pose = *next;
  }
  refined.world_from_camera = pose;
  // The noise model may be off by a factor: scale by the residuals' own size.
  // A point on a line has two of them.
  const double degrees = std::max(1.0, 3 * sum.weights - sum.line_weights - 6);
  const Matrix6 covariance =
      h.ldlt().solve(Matrix6::Identity()) * std::max(1.0, sum.value / degrees);
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      refined.covariance[static_cast<size_t>(6 * r + c)] =
          0.5 * (covariance(r, c) + covariance(c, r));
    }
  }
  refined.supported.assign(scene.size(), -1);
  const size_t end = std::min(scene.size(), options.max_points);
  for (size_t i = 0; i < end; ++i) {
    const NearestPrediction nearest =
        Nearest(scene, i, pose * scene.point_in_camera[i]);
    if (nearest.squared_distance <=
        options.inlier_distance_m * options.inlier_distance_m) {
      refined.supported[i] = static_cast<int8_t>(nearest.k);
      ++refined.inliers;
    }
  }
  if (!geometry::IsFinite(pose)) return std::nullopt;
  return refined;
}

}  // namespace treeline::pose

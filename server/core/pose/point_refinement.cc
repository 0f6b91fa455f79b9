#include "server/core/pose/point_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "server/core/pose/normal_equations.h"
#include "server/core/pose/parameters.h"

namespace treeline::pose {
namespace {

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

// DampableResiduals of points on points and points on lines.
class PointResiduals {
 public:
  PointResiduals(const PointPredictions& scene,
                 const PointRefinementOptions& options)
      : scene_(scene), options_(options) {}

  RobustSum SumAt(const geometry::Rigid3& pose, double scale) {
    scale2_ = scale * scale;
    line_weights_ = 0;
    terms_.clear();
    RobustSum sum;
    const size_t end = std::min(scene_.size(), options_.max_points);
    const geometry::Mat3 rotation = pose.rotation.Matrix();
    for (size_t i = 0; i < end; ++i) AddPoint(i, rotation, pose, sum);
    // A point on a line has two residuals, any other three.
    sum.residuals = 3 * sum.weights - line_weights_;
    return sum;
  }

  double ValueAt(const geometry::Rigid3& pose) const {
    double value = 0;
    for (const Term& term : terms_) {
      const geometry::Vec3 residual =
          pose * scene_.point_in_camera[term.point] - term.mean_in_world;
      value += QuadraticForm(
          scene_.is_on_line(term.point)
              ? AcrossLine(
                    term.information,
                    pose.rotation * scene_.line_direction_in_camera[term.point])
              : term.information,
          residual);
    }
    return value;
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
  Match MatchOf(size_t i, geometry::Vec3 rotated, geometry::Vec3 translation,
                geometry::Vec3 direction) const {
    Match best;
    for (int k = 0; k < scene_.per_sample; ++k) {
      const geometry::Vec3 residual =
          rotated + translation - scene_.at(i, k).mean_in_world;
      Match match{k, SquaredDistance(residual, direction), 0, {}};
      if (match.squared_distance > kRobustReach * kRobustReach * scale2_)
        continue;
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

  // `rotation` is the pose's.
  void AddPoint(size_t i, const geometry::Mat3& rotation,
                const geometry::Rigid3& pose, RobustSum& sum) {
    const geometry::Vec3 rotated = rotation * scene_.point_in_camera[i];
    const bool on_line = scene_.is_on_line(i);
    const geometry::Vec3 direction =
        on_line ? rotation * scene_.line_direction_in_camera[i]
                : geometry::Vec3{};
    const Match match = MatchOf(i, rotated, pose.translation, direction);
    if (match.k < 0) return;
    const double robust = scale2_ * scale2_ /
                          ((scale2_ + match.squared_distance) *
                           (scale2_ + match.squared_distance));
    Symmetric3 w = match.information;
    for (double& entry : w) entry *= robust;
    const geometry::Vec3 mean = scene_.at(i, match.k).mean_in_world;
    geometry::Vec3 x = rotated;
    geometry::Vec3 residual = rotated + pose.translation - mean;
    if (options_.levenberg_marquardt) terms_.push_back({i, mean, w});
    if (on_line) {
      const geometry::Vec3 along =
          ClosestOnLine(w, residual, direction) * direction;
      x = x + along;
      residual = residual + along;
      w = AcrossLine(w, direction);
      line_weights_ += robust;
    }
    sum.equations.Add(w, x, residual);
    sum.value += QuadraticForm(w, residual);
    sum.weights += robust;
  }

  const PointPredictions& scene_;
  const PointRefinementOptions& options_;
  // Of the last sum.
  double scale2_ = 0;
  double line_weights_ = 0;  // the part of points on lines
  std::vector<Term> terms_;
};

}  // namespace

std::optional<RefinedPose> RefinePoints(
    const PointPredictions& scene, const geometry::Rigid3& world_from_camera,
    const PointRefinementOptions& options) {
  PointResiduals residuals(scene, options);
  const std::optional<Minimum> minimum =
      MinimizeRobustly(residuals, world_from_camera,
                       {.iterations = options.iterations,
                        .robust_scale = options.robust_scale_m,
                        .initial_scale = kInitialRobustScale,
                        .min_rcond = kMinPointRcond,
                        .levenberg_marquardt = options.levenberg_marquardt});
  if (!minimum) return std::nullopt;
  const geometry::Mat3 rotation = minimum->world_from_camera.rotation.Matrix();
  return SupportedPose(
      *minimum, scene.size(), options.max_points, options.inlier_distance_m,
      [&](size_t i) {
        const geometry::Vec3 point = rotation * scene.point_in_camera[i] +
                                     minimum->world_from_camera.translation;
        return NearestOf(scene.per_sample, [&](int k) {
          return geometry::SquaredNorm(point - scene.at(i, k).mean_in_world);
        });
      });
}

}  // namespace treeline::pose

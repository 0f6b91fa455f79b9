// The robust least squares that every refinement of a pose runs, whatever its
// residuals are.
#ifndef SERVER_CORE_POSE_ROBUST_REFINEMENT_H_
#define SERVER_CORE_POSE_ROBUST_REFINEMENT_H_

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "common/geometry/rigid3.h"
#include "server/core/pose/normal_equations.h"
#include "server/core/pose/parameters.h"

namespace treeline::pose {

// A pose, how well it is known, and what supports it.
struct RefinedPose {
  geometry::Rigid3 world_from_camera;
  geometry::PoseCovariance covariance{};
  int inliers = 0;
  // Which prediction each sample supports; -1: none (an outlier).
  std::vector<int8_t> supported;
};

// A sum of weighted squares at one pose.
struct RobustSum {
  NormalEquations equations;
  double value = 0;
  // Sum of the robust weights, each in [0, 1].
  double weights = 0;
  // The same, with each sample as often as it has independent residuals.
  double residuals = 0;
};

// Residuals of samples that pick their predictions anew at every pose: the sum
// at a pose, samples further than a few times `scale` left out.
template <typename R>
concept PoseResiduals = requires(R& residuals, const geometry::Rigid3& pose,
                                 double scale) {
  { residuals.SumAt(pose, scale) } -> std::same_as<RobustSum>;
};

// ... and the value of the last sum at another pose, with the predictions and
// the weights as they were.
template <typename R>
concept DampableResiduals = PoseResiduals<R> &&
    requires(const R& residuals, const geometry::Rigid3& pose) {
  { residuals.ValueAt(pose) } -> std::same_as<double>;
};

struct RobustOptions {
  int iterations = 8;
  // Scale of the robust loss in the second half of the iterations, in units of
  // the residuals. It starts `initial_scale` times as large and shrinks.
  double robust_scale = 1;
  double initial_scale = 1;
  // Equations of a smaller reciprocal condition number determine no pose.
  double min_rcond = 1e-12;
  // Levenberg-Marquardt: a step that raises the sum is damped and tried again.
  // Needs DampableResiduals.
  bool levenberg_marquardt = false;
};

struct Minimum {
  geometry::Rigid3 world_from_camera;
  RobustSum sum;  // before the last step
};

// The minimum of the equations' quadratic as a pose, with a diagonal that is
// (1 + damping) times its own. nullopt: they are singular.
std::optional<geometry::Rigid3> SolveStep(
    const NormalEquations& equations, double damping, double min_rcond,
    const geometry::Rigid3& world_from_camera);

// Of the minimum. The noise model may be off by a factor: it is scaled by the
// residuals' own size where that is larger.
geometry::PoseCovariance CovarianceOf(const RobustSum& sum);

// One step from `pose`; damping carries over to the next one. `pose` itself if
// no damping helps, nullopt if there is no step.
template <DampableResiduals Residuals>
std::optional<geometry::Rigid3> DampedStep(const Residuals& residuals,
                                           const RobustSum& sum,
                                           double min_rcond,
                                           const geometry::Rigid3& pose,
                                           double& damping) {
  for (int attempt = 0; attempt < kMaxDampedSteps; ++attempt) {
    const std::optional<geometry::Rigid3> next =
        SolveStep(sum.equations, damping, min_rcond, pose);
    if (!next) return std::nullopt;
    if (residuals.ValueAt(*next) <= sum.value) {
      damping = std::max<double>(kMinDamping, damping / kDampingFactor);
      return next;
    }
    damping *= kDampingFactor;
  }
  return pose;
}

// Gauss-Newton, or Levenberg-Marquardt, from a pose. nullopt: the samples do
// not determine a pose.
template <PoseResiduals Residuals>
std::optional<Minimum> MinimizeRobustly(
    Residuals& residuals, const geometry::Rigid3& world_from_camera,
    const RobustOptions& options) {
  Minimum minimum{world_from_camera, {}};
  geometry::Rigid3& pose = minimum.world_from_camera;
  double damping = kMinDamping;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const double progress = std::min(
        1.0, static_cast<double>(iteration) / (0.5 * options.iterations));
    const double scale =
        options.robust_scale * std::pow(options.initial_scale, 1 - progress);
    minimum.sum = residuals.SumAt(pose, scale);
    if (minimum.sum.weights < kMinRobustWeights) return std::nullopt;
    std::optional<geometry::Rigid3> next;
    if constexpr (DampableResiduals<Residuals>) {
      next = options.levenberg_marquardt
                 ? DampedStep(residuals, minimum.sum, options.min_rcond, pose,
                              damping)
                 : SolveStep(minimum.sum.equations, 0, options.min_rcond, pose);
    } else {
      next = SolveStep(minimum.sum.equations, 0, options.min_rcond, pose);
    }
    if (!next || !geometry::IsFinite(*next)) return std::nullopt;
    pose = *next;
  }
  return minimum;
}

// A sample's prediction next to what was observed.
struct NearestPrediction {
  int k = -1;  // none
  double squared_distance = std::numeric_limits<double>::infinity();
};

// Of predictions [0, count), by squared_distance(k).
template <typename SquaredDistance>
NearestPrediction NearestOf(int count,
                            const SquaredDistance& squared_distance) {
  NearestPrediction nearest;
  for (int k = 0; k < count; ++k) {
    const double distance = squared_distance(k);
    if (distance < nearest.squared_distance) nearest = {k, distance};
  }
  return nearest;
}

// The pose with what supports it: of `samples` samples, the first `looked_at`
// whose nearest(i) lies within inlier_distance.
template <typename Nearest>
RefinedPose SupportedPose(const Minimum& minimum, size_t samples,
                          size_t looked_at, double inlier_distance,
                          const Nearest& nearest) {
  RefinedPose refined;
  refined.world_from_camera = minimum.world_from_camera;
  refined.covariance = CovarianceOf(minimum.sum);
  refined.supported.assign(samples, -1);
  for (size_t i = 0; i < std::min(samples, looked_at); ++i) {
    const NearestPrediction found = nearest(i);
    if (!(found.squared_distance <= inlier_distance * inlier_distance)) {
      continue;
    }
    refined.supported[i] = static_cast<int8_t>(found.k);
    ++refined.inliers;
  }
  return refined;
}

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_ROBUST_REFINEMENT_H_

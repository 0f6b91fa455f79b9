// How well a scan fits the map at a pose, and the pose near by where it fits
// best.
#ifndef NAV_AGENT_LOCALIZATION_SCAN_FIT_H_
#define NAV_AGENT_LOCALIZATION_SCAN_FIT_H_

#include <cmath>
#include <optional>
#include <span>

#include "nav_agent/core/level_pose.h"

namespace treeline::localization {

// Of the beams that can be judged: the share that the map explains, and the
// share that passes through what the map has; both in [0, 1].
struct ScanFit {
  double explained = 0;
  double contradicted = 0;
  int judged = 0;
};

// In [-1, 1]; higher is better.
inline double FitScore(const ScanFit& fit) {
  return fit.explained - fit.contradicted;
}

// A pose that a scan was compared at.
struct FittedPose {
  core::LevelPose pose;
  ScanFit fit;
  // What the search maximizes: the fit's score, less what the caller charges.
  double score = 0;
};

// The distance between neighbouring poses of one pass.
struct FitStep {
  double m = 0;
  double rad = 0;
};

// A coarse-to-fine grid search. Each pass tries nine positions by three
// headings around the best pose so far. fit_at(pose) gives the fit, nullopt
// where the scan says nothing; score_of(pose, fit) is what counts. Another pose
// is better only if it gains more than min_gain; of equals the first stays.
template <typename FitAt, typename ScoreOf>
FittedPose RefineFit(FittedPose best, std::span<const FitStep> passes,
                     double min_gain, const FitAt& fit_at,
                     const ScoreOf& score_of) {
  for (const FitStep& step : passes) {
    const core::LevelPose middle = best.pose;
    for (int i = 0; i < 27; ++i) {
      const double x = i % 3 - 1;
      const double y = (i / 3) % 3 - 1;  // NOLINT(bugprone-integer-division)
      const double turn = i / 9 - 1;     // NOLINT(bugprone-integer-division)
      core::LevelPose pose = middle;
      pose.map_from_base.translation = middle.map_from_base.translation +
                                       geometry::Vec2{step.m * x, step.m * y};
      pose.map_from_base.yaw_rad = geometry::NormalizedAngle_rad(
          middle.map_from_base.yaw_rad + step.rad * turn);
      const std::optional<ScanFit> fit = fit_at(pose);
      if (!fit.has_value()) continue;
      const double score = score_of(pose, *fit);
      if (score > best.score + min_gain) best = {pose, *fit, score};
    }
  }
  return best;
}

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_SCAN_FIT_H_

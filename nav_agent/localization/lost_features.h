// What speaks for a robot being lost, as numbers: one vector for each scan.
#ifndef NAV_AGENT_LOCALIZATION_LOST_FEATURES_H_
#define NAV_AGENT_LOCALIZATION_LOST_FEATURES_H_

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/localization/amcl.h"
#include "nav_agent/localization/lost_scan_check.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {

// Evidence of one scan, each in [0, 1], and more is always worse.
enum LostFeature : size_t {
  // Of the beams that see the map or pass through it, those that pass through.
  kLongShare,
  // How far from obstacles those end that are explained.
  kResidual,
  // Of the beams that something fixed stops, those that something stops that
  // the map does not have and that keeps its place as the robot moves.
  kChangedShare,
  // By how much fewer beams are explained than where the robot knew its place.
  kDeficit,
  // How the estimate moves otherwise than the wheels, over a second.
  kSlide,
  // How far apart particles are, and how many are elsewhere.
  kSpread,
  kElsewhere,
  kLostFeatures
};

struct LostFeatures {
  std::array<double, kLostFeatures> values{};
  // Of the beams that see the map or pass through it, those that do so all at
  // once: half a second ago, moved as the wheels say, they were otherwise.
  // Kidnaps are like that, and so are wheels that slip or turn in the air.
  double jump = 0;
  // The robot tilts as it cannot on its wheels: it is being carried.
  bool is_lifted = false;
  // It stands on a slope, where localization is less exact and fewer beams see
  // what the map has.
  bool is_on_slope = false;
  // Of the judged beams: what moves and what stands that the map does not
  // have, and what it has that is gone.
  double moving_share = 0;
  double changed_share = 0;
  double long_share = 0;
  double explained_share = 0;
};

// One scan with all that belongs to it.
struct LostEvidence {
  base::MonotonicTime stamp;
  // The estimate of localization at the time of the scan.
  PlanarEstimate estimate;
  // What the wheels say, of the same time; drifts, but does not jump.
  geometry::Rigid2 odom_from_base;
  // Of the inertial sensor; nose down and right side down are positive.
  double pitch_rad = 0;
  double roll_rad = 0;
};

struct LostFeatureOptions {
  // What is as many beams of no evidence as this share of all beams: few beams
  // say little. [0, 1]
  double prior_share = kFewBeamsPrior;
  // A robot that drives does not tilt further than this, and does not begin to
  // do so faster.
  double lifted_rad = kLifted_rad;      // [0.05, 1.5]
  double lifted_radps = kLifted_radps;  // [0.1, 20]
  double slide_m = kSlide_m;            // a slide of 1; [0.01, 10]
  double spread_m = kSpread_m;          // a spread of 1; [0.01, 10]
  double history_s = kFitHistory_s;  // what scans are compared with; [1, 3600]
  double usual_explained = kUsualExplained;  // before there is any; [0, 1]

  absl::Status Validate() const;
};

// Remembers a second of scans, and how well they used to fit. Deterministic,
// not thread-safe.
class LostFeatureMaker {
 public:
  explicit LostFeatureMaker(const LostFeatureOptions& options)
      : options_(options), usual_explained_(options.usual_explained) {}

  // Scans in the order of time. `doubt` in [0, 1]: the probability so far that
  // the robot is lost; what a lost robot sees is no history.
  LostFeatures Observe(const LostEvidence& evidence,
                       const std::vector<CheckedBeam>& beams, double doubt);
  // The robot was put somewhere: nothing before counts.
  void Reset();

 private:
  struct Past {
    base::MonotonicTime stamp;
    geometry::Rigid2 odom_from_base;
    geometry::Rigid2 map_from_base;
    double pitch_rad = 0;
    double roll_rad = 0;
    std::vector<geometry::Vec2> ends_in_base;
  };
  // The last that is at least so old; null: none.
  const Past* Before(base::MonotonicTime now, double age_s) const;
  void WatchTilt(const LostEvidence& evidence, LostFeatures& features) const;
  void Count(const std::vector<CheckedBeam>& beams,
             const std::vector<bool>& was_there, double doubt,
             double interval_s, LostFeatures& features);

  LostFeatureOptions options_;
  double usual_explained_;
  std::deque<Past> past_;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_LOST_FEATURES_H_

// Whether a robot is lost: a verdict from scan to scan.
// docs/explanation/lost-detection.md says how it was calibrated and how good it
// is.
#ifndef NAV_AGENT_LOCALIZATION_LOST_DETECTOR_H_
#define NAV_AGENT_LOCALIZATION_LOST_DETECTOR_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/localization/known_things.h"
#include "nav_agent/localization/lost_features.h"
#include "nav_agent/localization/lost_scan_check.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {

// log p(features | lost) / p(features | not lost) = bias + sum of weight *
// feature: a logistic regression on as many scans of both kinds, with weights
// of at least 0, so that worse evidence never speaks for the robot.
struct LostModel {
  double bias = 0;
  std::array<double, kLostFeatures> weights{};

  double LogRatio(const std::array<double, kLostFeatures>& values) const;

  // What `treeline-agent suite lost-fit` makes of training worlds.
  static LostModel Trained();
};

struct LostFilterOptions {
  LostModel model = LostModel::Trained();
  // Scans of a robot that stands still tell the same again and again: all
  // those within this time count as one (s). [0.01, 60]
  double independent_s = kEvidenceInterval_s;
  // One such says at most so much, for and against. [0.1, 100]
  double max_log_odds_for = kMaxEvidenceFor;
  double max_log_odds_against = kMaxEvidenceAgainst;
  // On a slope (LostFeatures::is_on_slope) it says this part of it. [0, 1]
  double slope_part = kSlopeEvidence;
  // How often robots get lost without anything to be seen of it (1/s). [0, 1]
  double loss_hz = kLossRate_hz;
  // From the first jump (LostFeatures::jump) on, up to the second, a scan means
  // a kidnap with up to this probability.
  double jump_from = kJumpFrom;          // [0, 1]
  double jump_to = kJumpTo;              // [jump_from, 1]
  double jump_chance = kKidnapChance;    // [0, 1)
  double lifted_chance = kKidnapChance;  // [0, 1)
  // The log of the odds stays within these, so that it can change. [0.1, 100]
  double max_log_odds_lost = kMaxLogOdds;
  double max_log_odds_not_lost = kMaxLogOdds;

  absl::Status Validate() const;
};

// The test: a Bayes filter with two states, lost and not lost, in logs of odds.
// It begins as a robot does that somebody has just put where it says it is.
class LostFilter {
 public:
  explicit LostFilter(const LostFilterOptions& options);

  // One scan's evidence, so long after the last one. The probability after it.
  double Observe(const LostFeatures& features, double interval_s);
  void Reset();

  double log_odds() const { return log_odds_; }
  double Probability() const;
  // Of the last scan, all of it: more than 0 speaks for being lost.
  double log_ratio() const { return log_ratio_; }

 private:
  LostFilterOptions options_;
  double log_odds_ = 0;
  double log_ratio_ = 0;
};

enum class LostState : uint8_t {
  kLocalized,
  // It knows its place, and something stands there that did not before, or is
  // gone.
  kMapChangedHere,
  // It knows its place; what hides the map moves.
  kPeopleNearby,
  kLost
};

// Why it is lost, or may be.
enum class LostReason : uint8_t {
  kNone,
  // Beams pass through what the map has.
  kPassesThroughWalls,
  // Scans do not fit, or much worse than they used to.
  kDoesNotFit,
  // All at once the robot saw another place.
  kJumped,
  kLifted,
  // Localization itself is not sure of one place.
  kNotSure
};

const char* LostStateName(LostState state);
const char* LostReasonName(LostReason reason);

struct LostVerdict {
  // That the robot is lost.
  double probability = 0;
  LostState state = LostState::kLocalized;
  LostReason reason = LostReason::kNone;
  LostFeatures features;
};

struct LostDetectorOptions {
  ScanCheckOptions scan;
  LostFeatureOptions features;
  LostFilterOptions filter;
  // Lost from this probability on, until it falls below the second.
  double declare_at = kDeclareLost;    // (0, 1)
  double withdraw_at = kWithdrawLost;  // [0, declare_at]
  // A state is named after what hides or changes this share of the beams.
  double notable_share = kNotableShare;  // [0, 1]
  // Scans sooner than this after the last one are not looked at (s). [0, 10]
  double min_interval_s = kScanInterval_s;

  absl::Status Validate() const;
};

// With augmented injection: the filter that localizes may find its place again
// by itself. Its estimate then jumps, which is evidence of having been lost
// (LostFeature::kSlide), and after that scans fit, which ends the verdict. So
// injection goes on while a robot is lost, and the verdict is of the estimate
// as it is now.
//
// Deterministic; not thread-safe.
class LostDetector {
 public:
  // INVALID_ARGUMENT for bad options and maps without cells.
  static absl::StatusOr<LostDetector> Create(
      const LaserMap& map, const core::RangeSensorInfo& laser,
      const geometry::Rigid3& base_from_laser,
      const LostDetectorOptions& options);

  // One scan, in the order of time. INVALID_ARGUMENT for a scan of another
  // number of beams, for evidence that is not finite, and for a clock that
  // goes back; the verdict stays as it was.
  absl::StatusOr<LostVerdict> Observe(const LostEvidence& evidence,
                                      const core::LaserScan& scan);

  // The robot was told where it is: everything before is forgotten.
  void Reset();
  // It drove onto another level; what was seen stays. INVALID_ARGUMENT for a
  // map without cells.
  absl::Status SetMap(const LaserMap& map);
  // The same with a checker that is there already, of the same options.
  void SetChecker(const ScanChecker& checker) { checker_ = checker; }
  // Beams that end at these are explained, as by the map; null: none.
  void SetKnownThings(std::shared_ptr<const KnownThings> things) {
    things_ = std::move(things);
  }

  const LostVerdict& verdict() const { return verdict_; }
  double log_odds() const { return filter_.log_odds(); }

 private:
  LostDetector(ScanChecker checker, const core::RangeSensorInfo& laser,
               const geometry::Rigid3& base_from_laser,
               const LostDetectorOptions& options);
  // What ends before the map's obstacles, at something that is known.
  void ExplainByThings(const PlanarEstimate& estimate,
                       std::vector<CheckedBeam>& beams) const;
  LostReason ReasonFor(const LostFeatures& features) const;
  LostState StateFor(const LostFeatures& features) const;

  LostDetectorOptions options_;
  ScanChecker checker_;
  core::RangeSensorInfo laser_;
  geometry::Rigid3 base_from_laser_;
  std::shared_ptr<const KnownThings> things_;
  LostFeatureMaker maker_;
  LostFilter filter_;
  std::optional<base::MonotonicTime> last_;
  // When the robot last seemed to be carried; see LostReason.
  std::optional<base::MonotonicTime> jumped_;
  std::optional<base::MonotonicTime> lifted_;
  LostVerdict verdict_;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_LOST_DETECTOR_H_

// What the laser alone says of where the robot is, while the server is asked.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "nav_agent/behavior/recovery.h"
#include "nav_agent/behavior/recovery_parts.h"

namespace treeline::behavior {
namespace {

// How well such a place is known: the search's last step is 6 cm and 2 degrees.
constexpr localization::PoseCovariance2 kClear = {0.01, 0, 0, 0,     0.01,
                                                  0,    0, 0, 0.0064};

constexpr int kQuestionsBeforeLaser = 4;

}  // namespace

void Recovery::BeginLook() {
  if (options_.method != RecoveryMethod::kServer || clear_was_tried_) return;
  const std::optional<base::MonotonicTime> stamp = tracker_.ScanStamp();
  if (!stamp.has_value()) return;
  look_motion_ = tracker_.MotionAt(*stamp);
  if (!look_motion_.has_value()) return;
  clear_.reset();
  tracker_.BeginOtherPlaces(std::nullopt);
  look_ = Look::kLooking;
}

void Recovery::StepLook(base::MonotonicTime now) {
  if (look_ != Look::kLooking || !tracker_.StepOtherPlaces()) return;
  look_ = Look::kDone;
  const std::vector<localization::RobotTracker::OtherPlace> places =
      tracker_.BestPlaces();
  if (places.empty()) return;
  const localization::RobotTracker::ScanFit& best = places.front().fit;
  if (best.explained < options_.search_explained ||
      best.contradicted > options_.search_contradicted ||
      best.judged < options_.gate.least_judged) {
    return;
  }
  const bool has_twin =
      places.size() > 1 &&
      ScoreOf(places[1].fit) > ScoreOf(best) - options_.alias_margin;
  if (has_twin) return;
  clear_ = places.front().pose;
  // Too late for a search that began without it?
  if (state_ == RecoveryState::kSearching && MayTryClear()) TryClear(now);
}

bool Recovery::MayTryClear() const {
  return clear_.has_value() && !clear_was_tried_ && !needs_help_ &&
         cause_ != RecoveryCause::kCheck;
}

bool Recovery::IsLasersTurn() const {
  return MayTryClear() &&
         (waiting_.empty() || questions_ >= kQuestionsBeforeLaser);
}

bool Recovery::IsClearPlace(const GatedFix& fix) const {
  if (!clear_.has_value() || !look_motion_.has_value()) return false;
  const core::LevelPose expected =
      CarriedOn(*clear_, *look_motion_, fix.motion, *map_);
  return geometry::Norm(expected.map_from_base.translation -
                        fix.pose.map_from_base.translation) <=
             options_.gate.pair_m &&
         std::abs(geometry::NormalizedAngle_rad(
             expected.map_from_base.yaw_rad -
             fix.pose.map_from_base.yaw_rad)) <= options_.gate.pair_rad &&
         std::abs(expected.place.height_m - fix.pose.place.height_m) <=
             options_.gate.pair_m;
}

bool Recovery::TryClear(base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return false;
  clear_was_tried_ = true;
  const core::LevelPose pose =
      CarriedOn(*clear_, *look_motion_, *motion, *map_);
  if (!tracker_.SetPose(pose, kClear, now).ok()) return false;
  was_seeded_ = true;
  searches_anywhere_ = true;
  holds_clear_ = true;
  BreakHold();
  Note("recovery",
       absl::StrFormat("scans fit at %.2f, %.2f on level %d, %.0f degrees, and "
                       "nowhere else: turns to see whether that holds",
                       pose.map_from_base.translation.x,
                       pose.map_from_base.translation.y, pose.place.level,
                       pose.map_from_base.yaw_rad * 57.29577951308232));
  return true;
}

}  // namespace treeline::behavior

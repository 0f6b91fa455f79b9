#include "nav_agent/behavior/confirming_state.h"

#include <algorithm>

#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"

namespace treeline::behavior {

ConfirmingState::ConfirmingState(const GatedFix& seed, bool seen_twice,
                                 RelocalizationTools& tools,
                                 base::MonotonicTime now)
    : seed_(seed), seen_twice_(seen_twice), since_(now) {
  tools.scans.ForgetCounts();
  tools.scans.SkipNewest(tools.tracker);
  tools.turns.Reset();
  tools.unique.ForgetOthers();
  tools.unique.EndWholeMap();
}

void ConfirmingState::TakeScan(const localization::TrackedPose& pose,
                               RelocalizationTools& tools) {
  tools.scans.CountInRow(tools.scans.Watch(
      tools.tracker, {.min_explained = tools.options.confirm_explained,
                      .max_contradicted = tools.options.confirm_contradicted,
                      .min_judged = MinJudgedOnTrial(tools.options)}));
  // Whether the laser alone would know this place from all others.
  if (tools.unique.others() == OtherPlaces::kNotSearched &&
      tools.scans.good() > 0) {
    tools.unique.BeginOthers(pose.pose);
  } else {
    tools.unique.StepOthers();
  }
}

const char* ConfirmingState::Against(const localization::TrackedMotion& motion,
                                     const localization::TrackedPose& pose,
                                     const RelocalizationTools& tools,
                                     base::MonotonicTime now) const {
  const core::LevelPose expected =
      PropagatedByOdometry(seed_.pose, seed_.motion, motion, *tools.map);
  const double drift_m = geometry::Norm(expected.map_from_base.translation -
                                        pose.pose.map_from_base.translation);
  if (tools.unique.others() == OtherPlaces::kBetter) {
    return "scans fit better elsewhere";
  }
  if (base::SecondsBetween(since_, now) > tools.options.max_confirm_s) {
    return "it was not confirmed in time";
  }
  if (drift_m > kMaxConfirmDrift_m) return "localization went elsewhere";
  if (tools.scans.bad() > kMaxBadScans ||
      tools.tracker.verdict().state == localization::LostState::kLost) {
    return "scans do not fit there";
  }
  return nullptr;
}

ConfirmingState::Result ConfirmingState::Step(const RelocalizationInput& input,
                                              RelocalizationTools& tools) {
  const std::optional<localization::TrackedMotion> motion =
      tools.tracker.Motion();
  const std::optional<localization::TrackedPose> pose = tools.tracker.Pose();
  if (!motion.has_value() || !pose.has_value()) return {};
  turned_rad_ += tools.turns.Add_rad(motion->odom_from_base.yaw_rad);
  TakeScan(*pose, tools);
  if (const char* why = Against(*motion, *pose, tools, input.now)) {
    return {.outcome = Outcome::kRefuted, .why = why, .wanted = {}};
  }
  const RelocalizationBehaviorOptions& options = tools.options;
  const OtherPlaces others = tools.unique.others();
  const bool fits =
      tools.scans.good() >= options.confirm_scans &&
      IsPoseTight(tools.tracker, kKnownShare, kMaxConfirmStd_m) &&
      tools.tracker.verdict().probability < kMaxConfirmLostProbability;
  const bool has_turned = turned_rad_ >= options.confirm_turn_rad;
  if (fits && has_turned) {
    // Camera and laser may both be wrong where rooms are alike: what the scan
    // shows somewhere else is waited for, if it could fit better there.
    if (others == OtherPlaces::kSearching && !tools.unique.IsBestPossible()) {
      return {};
    }
    if (seen_twice_ || others == OtherPlaces::kNone) {
      return {.outcome = Outcome::kFound,
              .why = seen_twice_ ? "seen twice, and scans fit"
                                 : "seen once, and scans fit nowhere else",
              .wanted = {}};
    }
    if (others == OtherPlaces::kAlike) {
      // Other places look the same to the laser: the camera must say it twice.
      return {.outcome = Outcome::kSecondView,
              .why = "the laser would fit elsewhere too",
              .wanted = {}};
    }
  }
  const bool has_no_room =
      fits && !input.can_turn &&
      base::SecondsBetween(since_, input.now) > kConfirmNoRoom_s;
  if (has_no_room && others == OtherPlaces::kNone) {
    if (seen_twice_) {
      return {.outcome = Outcome::kFound,
              .why = "seen twice, and scans fit nowhere else",
              .wanted = {}};
    }
    return {.outcome = Outcome::kSecondView,
            .why = "there is no room to turn",
            .wanted = {}};
  }
  if (has_turned) return {};
  return {.outcome = Outcome::kOpen,
          .why = "",
          .wanted = tools.swing.Step(
              *motion, input, std::min(kConfirmTurn_radps, options.turn_radps),
              options.move_mps)};
}

}  // namespace treeline::behavior

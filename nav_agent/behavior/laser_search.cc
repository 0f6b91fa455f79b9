#include "nav_agent/behavior/laser_search.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"

namespace treeline::behavior {
namespace {

localization::PoseCovariance2 UniquePlaceCovariance() {
  return {kUniquePlaceVariance_m2,  0, 0, 0, kUniquePlaceVariance_m2, 0, 0, 0,
          kUniquePlaceVariance_rad2};
}

}  // namespace

LaserSearch::LaserSearch(RelocalizationTools& tools, base::MonotonicTime now)
    : began_(now), last_pause_(now) {
  BreakHold(tools);
  tools.turns.Reset();
  tools.search_motion.Begin(now);
}

void LaserSearch::BreakHold(RelocalizationTools& tools) {
  holds_since_.reset();
  hold_turned_rad_ = 0;
  tools.scans.ForgetCounts();
  tools.unique.ForgetOthers();
}

bool LaserSearch::TryUniquePlace(const UniquePlace& place,
                                 const localization::TrackedMotion& motion,
                                 RelocalizationTools& tools,
                                 base::MonotonicTime now) {
  const core::LevelPose pose =
      PropagatedByOdometry(place.pose, place.motion, motion, *tools.map);
  if (!tools.tracker.SetPose(pose, UniquePlaceCovariance(), now).ok()) {
    return false;
  }
  has_told_amcl_ = true;
  holds_unique_place_ = true;
  has_spread_ = false;
  was_in_doubt_ = false;
  BreakHold(tools);
  tools.report.Note(
      "recovery", absl::StrCat("scans fit at ", PoseText(pose),
                               ", and nowhere else: turns to see whether that "
                               "holds"));
  return true;
}

void LaserSearch::LookEverywhere(RelocalizationTools& tools,
                                 base::MonotonicTime now) {
  holds_unique_place_ = false;
  was_in_doubt_ = false;
  if (tools.options.method == RelocalizationMethod::kInjectionOnly &&
      tools.tracker.Pose().has_value()) {
    return;
  }
  tools.tracker.StartGlobalLocalization(now);
  has_told_amcl_ = true;
  has_spread_ = true;
  BreakHold(tools);
}

bool LaserSearch::IsLikeliest(const GatedFix& fix,
                              const RelocalizationTools& tools) {
  const std::optional<localization::TrackedPose> pose = tools.tracker.Pose();
  const std::optional<localization::TrackedMotion> motion =
      tools.tracker.Motion();
  if (IsRefused(fix.verdict) || PlacesLeft(tools.tracker).empty() ||
      !motion.has_value()) {
    return false;
  }
  const double log_odds =
      std::log(pose->place_share) - std::log1p(-pose->place_share);
  return log_odds >= kSureLogOdds &&
         AreWithin(
             PropagatedByOdometry(fix.pose, fix.motion, *motion, *tools.map),
             pose->pose, tools.options.gate.pair_m,
             tools.options.gate.pair_rad);
}

void LaserSearch::NoteRefuted(RelocalizationTools& tools) {
  has_told_amcl_ = false;
  tools.search_motion.CountOneTurn();
}

void LaserSearch::AddTurn(const localization::TrackedMotion& motion,
                          RelocalizationTools& tools) {
  const double turned_rad = tools.turns.Add_rad(motion.odom_from_base.yaw_rad);
  tools.search_motion.AddTurn(turned_rad);
  if (holds_since_.has_value()) hold_turned_rad_ += turned_rad;
}

bool LaserSearch::Holds(RelocalizationTools& tools, base::MonotonicTime now) {
  const RelocalizationBehaviorOptions& options = tools.options;
  const ScanVerdict scan = tools.scans.Watch(
      tools.tracker, {.min_explained = options.search_explained,
                      .max_contradicted = options.search_contradicted,
                      .min_judged = MinJudgedOnTrial(options)});
  tools.scans.Count(scan);
  const std::optional<localization::TrackedPose> pose = tools.tracker.Pose();
  was_in_doubt_ =
      was_in_doubt_ || (has_spread_ && pose.has_value() && pose->in_doubt);
  const bool is_tight =
      IsPoseGathered(tools.tracker, options.search_share,
                     options.search_std_m) &&
      tools.tracker.verdict().state != localization::LostState::kLost &&
      !HasJumped(tools);
  const bool fits = tools.scans.bad() <=
                    kFreeBadScans + kMaxBadScanShare * tools.scans.good();
  if (!is_tight || !fits) {
    BreakHold(tools);
    return false;
  }
  if (!holds_since_.has_value()) {
    if (scan != ScanVerdict::kGood) return false;
    holds_since_ = now;
  }
  if (pose->in_doubt ||
      base::SecondsBetween(*holds_since_, now) < options.search_hold_s ||
      hold_turned_rad_ < options.search_hold_rad ||
      tools.tracker.verdict().probability > kMaxSearchLostProbability) {
    return false;
  }
  // One scan says less than those of all viewpoints.
  return was_in_doubt_ || IsOnlyPlace(tools);
}

bool LaserSearch::HasJumped(RelocalizationTools& tools) {
  const std::optional<localization::TrackedPose> pose = tools.tracker.Pose();
  const std::optional<localization::TrackedMotion> motion =
      tools.tracker.Motion();
  const std::optional<Before> before = std::exchange(before_, std::nullopt);
  if (!pose.has_value() || !motion.has_value()) return false;
  before_ = {.pose = pose->pose, .motion = *motion};
  if (!before.has_value()) return false;
  return !AreWithin(
      PropagatedByOdometry(before->pose, before->motion, *motion, *tools.map),
      pose->pose, localization::kOtherPlace_m, localization::kOtherPlace_rad);
}

bool LaserSearch::IsOnlyPlace(RelocalizationTools& tools) {
  UniquePlaceSearch& unique = tools.unique;
  switch (unique.others()) {
    case OtherPlaces::kNotSearched:
      unique.EndWholeMap();
      unique.BeginOthers(tools.tracker.Pose()->pose);
      return false;
    case OtherPlaces::kSearching:
      if (!unique.StepOthers()) return false;
      others_turned_rad_ = hold_turned_rad_;
      if (unique.others() != OtherPlaces::kNone) {
        tools.report.Note(
            "recovery",
            "the laser fits another place as well: goes on looking");
      }
      break;
    case OtherPlaces::kNone:
      break;
    case OtherPlaces::kAlike:
    case OtherPlaces::kBetter:
      // One scan said that it fits nowhere else, another one that it does: a
      // third. Rooms that are alike are so in all of them.
      if (holds_unique_place_ &&
          hold_turned_rad_ - others_turned_rad_ > kNewViewTurn_rad) {
        unique.ForgetOthers();
      }
      break;
  }
  return unique.others() == OtherPlaces::kNone;
}

bool LaserSearch::IsTimeToAsk(const ServerState& server,
                              base::MonotonicTime now) const {
  if (!server.may_be_asked || server.is_asked) return false;
  return base::SecondsBetween(last_pause_, now) >
         (server.has_failed ? kAskFailedInterval_s : kAskInterval_s);
}

LaserSearch::Outcome LaserSearch::EndTurn(const ServerState& server,
                                          RelocalizationTools& tools,
                                          base::MonotonicTime now) {
  const std::optional<localization::TrackedPose> pose = tools.tracker.Pose();
  // One full turn, and what particles gathered at does not hold.
  const bool is_wrong =
      !holds_since_.has_value() && (!pose.has_value() || !pose->is_searching);
  if (tools.unique.others() == OtherPlaces::kAlike ||
      tools.unique.others() == OtherPlaces::kBetter) {
    tools.unique.ForgetOthers();
  }
  if (holds_unique_place_ && is_wrong && server.may_be_asked) {
    // It was not there: the camera's turn again.
    tools.report.Note("recovery",
                      "what the laser said does not hold: looks elsewhere");
    return Outcome::kCamerasTurn;
  }
  if (!has_told_amcl_ || is_wrong) LookEverywhere(tools, now);
  return Outcome::kOpen;
}

LaserSearch::Result LaserSearch::Step(const RelocalizationInput& input,
                                      const localization::TrackedMotion& motion,
                                      const ServerState& server,
                                      RelocalizationTools& tools) {
  if (Holds(tools, input.now))
    return {.outcome = Outcome::kFound, .wanted = {}};
  if (base::SecondsBetween(began_, input.now) > tools.options.max_search_s) {
    return {.outcome = Outcome::kTimeIsUp, .wanted = {}};
  }
  if (IsTimeToAsk(server, input.now)) {
    last_pause_ = input.now;
    return {.outcome = Outcome::kAsks, .wanted = {}};
  }
  return Move(input, motion, server, tools);
}

LaserSearch::Result LaserSearch::Move(const RelocalizationInput& input,
                                      const localization::TrackedMotion& motion,
                                      const ServerState& server,
                                      RelocalizationTools& tools) {
  if (parting_.is_choosing()) {
    parting_.Step(motion, tools, input.now);
    return {};
  }
  SearchMotion& search = tools.search_motion;
  // What it drives for has come about, or nothing is missing but a turn.
  const bool lacks_turn = holds_since_.has_value() &&
                          hold_turned_rad_ < tools.options.search_hold_rad;
  if ((search.is_under_way() || (search.is_moving() && lacks_turn)) &&
      PlacesLeft(tools.tracker).size() < 2) {
    search.EndWay(motion, input.now);
  }
  const SearchMotion::Result moved =
      search.Step(motion, input,
                  {.turn_radps = tools.options.turn_radps,
                   .move_mps = tools.options.move_mps},
                  tools.swing);
  Result result = {.outcome = Outcome::kOpen, .wanted = moved.wanted};
  if (moved.has_turned_around) {
    result.outcome = EndTurn(server, tools, input.now);
  }
  if (result.outcome == Outcome::kOpen &&
      (moved.has_turned_around || moved.has_arrived)) {
    parting_.Begin(motion, moved.was_blocked, tools);
  }
  return result;
}

}  // namespace treeline::behavior

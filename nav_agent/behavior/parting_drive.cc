#include "nav_agent/behavior/parting_drive.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"

namespace treeline::behavior {
namespace {

// So many are listed for people.
constexpr size_t kListed = 4;

}  // namespace

std::vector<localization::PossiblePlace> PlacesLeft(
    const localization::RobotTracker& tracker) {
  const std::optional<localization::TrackedPose> pose = tracker.Pose();
  if (!pose.has_value() || !pose->in_doubt || pose->is_searching ||
      pose->place_share == 0) {
    return {};
  }
  std::vector<localization::PossiblePlace> places = {
      {.pose = pose->pose, .share = pose->place_share}};
  places.insert(places.end(), pose->other_places.begin(),
                pose->other_places.end());
  return places;
}

void PartingDrive::Begin(const localization::TrackedMotion& motion,
                         bool was_blocked, RelocalizationTools& tools) {
  const geometry::Rigid2& odom_from_base = motion.odom_from_base;
  if (was_blocked) {
    blocked_in_odom_.push_back(
        odom_from_base *
        geometry::Vec2{tools.robot.front_m + kMinSearchMove_m, 0});
  }
  view_.reset();
  places_ = PlacesLeft(tools.tracker);
  if (places_.size() < 2) return;
  // Unlikely ones would only narrow the ways that are free for all.
  std::vector<localization::PossiblePlace> likely = places_;
  std::ranges::stable_sort(likely, std::greater(),
                           &localization::PossiblePlace::share);
  while (likely.size() > 2 && likely.back().share < kPartingMinShare) {
    likely.pop_back();
  }
  std::vector<geometry::Vec2> obstacles = blocked_in_odom_;
  for (const geometry::Vec2& end : tools.tracker.ScanInBase()) {
    obstacles.push_back(odom_from_base * end);
  }
  seen_from_in_odom_.push_back(odom_from_base.translation);
  view_.emplace(*tools.map, std::move(likely), odom_from_base, obstacles,
                seen_from_in_odom_, tools.robot.half_width_m + kPartingRoom_m);
}

void PartingDrive::Step(const localization::TrackedMotion& motion,
                        RelocalizationTools& tools, base::MonotonicTime now) {
  if (!view_.has_value() || !view_->Step(tools.tracker)) return;
  const std::optional<PartingLeg> leg = view_->leg();
  view_.reset();
  NoteChoice(places_, leg, tools);
  if (leg.has_value()) {
    tools.search_motion.GoTo(leg->yaw_rad, leg->way_m, kKnownWayMove_mps,
                             motion, now);
  } else {
    tools.search_motion.Resume(now);
  }
}

void PartingDrive::NoteChoice(
    const std::vector<localization::PossiblePlace>& places,
    const std::optional<PartingLeg>& leg, RelocalizationTools& tools) const {
  std::string text = absl::StrCat(places.size(), " places are left: ");
  for (size_t i = 0; i < std::min(places.size(), kListed); ++i) {
    absl::StrAppend(&text, i == 0 ? "" : "; ", PoseText(places[i].pose),
                    absl::StrFormat(" (%.0f %%)", 100 * places[i].share));
  }
  if (places.size() > kListed) absl::StrAppend(&text, "; and others");
  if (leg.has_value()) {
    absl::StrAppend(&text, absl::StrFormat(": drives %.1f m to where they "
                                           "differ (%.0f %%)",
                                           leg->way_m, 100 * leg->gain));
  } else {
    absl::StrAppend(&text, ": no view in reach parts them");
  }
  tools.report.Note("recovery", std::move(text));
}

}  // namespace treeline::behavior

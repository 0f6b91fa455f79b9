#include "nav_agent/behavior/navigator_poses.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {

bool IsFinite(const core::LevelPose& pose) {
  return std::isfinite(pose.map_from_base.translation.x) &&
         std::isfinite(pose.map_from_base.translation.y) &&
         std::isfinite(pose.map_from_base.yaw_rad) &&
         std::isfinite(pose.place.height_m);
}

absl::Status CheckOnLevels(const core::LevelPose& pose, const std::string& what,
                           int levels) {
  if (!IsFinite(pose)) {
    return absl::InvalidArgumentError(absl::StrCat(what, " is not finite"));
  }
  if (pose.place.level < 0 || pose.place.level >= levels) {
    return absl::InvalidArgumentError(
        absl::StrCat(what, " on level ", pose.place.level,
                     "; the map has levels 0 to ", levels - 1));
  }
  return absl::OkStatus();
}

absl::Status CheckNotKeptOut(const core::LevelPose& pose,
                             const std::string& what,
                             const zones::ZoneMap* zones) {
  const geometry::Vec2 at = pose.map_from_base.translation;
  if (zones == nullptr || !zones->IsKeptOut(pose.place.level, at)) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrFormat(
      "%s (%.2f, %.2f) on level %d is refused: it lies in the keep-out zone "
      "'%s'",
      what, at.x, at.y, pose.place.level,
      zones->KeepOutName(pose.place.level, at)));
}

absl::Status CheckSteering(const SteeringCommand& steering, int levels,
                           const zones::ZoneMap* zones) {
  if (!std::isfinite(steering.wanted.forward_mps) ||
      !std::isfinite(steering.wanted.yaw_rate_radps)) {
    return absl::InvalidArgumentError("a velocity is not finite");
  }
  TL_RETURN_IF_ERROR(CheckOnLevels(steering.docked, "a dock", levels));
  // Who is in a zone must be able to leave it.
  if (steering.is_leaving) return absl::OkStatus();
  return CheckNotKeptOut(steering.docked, "the dock", zones);
}

std::optional<StopReason> EstimateProblem(
    const std::optional<control::ControlPose>& pose, base::MonotonicTime now) {
  if (!pose.has_value()) return std::nullopt;
  const double age_s = base::SecondsBetween(pose->stamp, now);
  if (IsFinite(pose->pose) && age_s <= kMaxEstimateAge_s) return std::nullopt;
  return StopReason{
      .cause = core::NavigationCause::kEstimateLost,
      .text = absl::StrFormat(
          "the estimate of its pose is %.2f s old, or not finite", age_s)};
}

std::optional<control::ControlPose> ControlPoseOf(
    const std::optional<localization::TrackedMotion>& motion) {
  if (!motion.has_value()) return std::nullopt;
  return control::ControlPose{
      .stamp = motion->stamp,
      .pose = {.map_from_base = motion->odom_from_base, .place = {}},
      .level_from_base = motion->level_from_base,
      .forward_mps = motion->forward_mps,
      .yaw_rate_radps = motion->yaw_rate_radps,
      .map_is_unknown = true};
}

std::optional<control::ControlPose> ControlPoseOf(
    const std::optional<localization::TrackedPose>& pose) {
  if (!pose.has_value()) return std::nullopt;
  return control::ControlPose{.stamp = pose->stamp,
                              .pose = pose->pose,
                              .level_from_base = pose->level_from_base,
                              .forward_mps = pose->forward_mps,
                              .yaw_rate_radps = pose->yaw_rate_radps,
                              .map_is_unknown = false};
}

std::vector<core::LevelPose> SupposedPlaces(
    const localization::TrackedPose& pose, RelocalizationState state) {
  if (state == RelocalizationState::kConfirming) return {pose.pose};
  if (state != RelocalizationState::kSearching || pose.is_searching) return {};
  // It is not known yet what else is possible.
  if (pose.in_doubt && pose.place_share == 0) return {};
  std::vector<core::LevelPose> places;
  if (pose.place_share >= kSupposedShare) places.push_back(pose.pose);
  for (const localization::PossiblePlace& other : pose.other_places) {
    if (other.share >= kSupposedShare) places.push_back(other.pose);
  }
  return places;
}

bool IsOnlyPlace(const localization::TrackedPose& pose) {
  return !pose.is_searching && !pose.in_doubt &&
         pose.place_share > 1 - kSupposedShare;
}

}  // namespace treeline::behavior

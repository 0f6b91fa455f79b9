#include "nav_agent/app/map/live_questions.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/mapping/seen_place.h"

namespace treeline::map_app {
namespace {

// The height of the ground that was driven on the nearest to a place, if that
// is near.
std::optional<double> GroundNear(
    const geometry::Vec3& place, double near_m,
    const std::vector<dataset::TimedPose>& driven) {
  // Storeys are above one another: the height counts, too.
  double nearest_m = near_m;
  std::optional<double> ground_m;
  for (const dataset::TimedPose& pose : driven) {
    const geometry::Vec3 apart = pose.world_from_camera.translation - place;
    const double distance_m = geometry::Norm(apart);
    if (distance_m > nearest_m) continue;
    nearest_m = distance_m;
    ground_m = pose.world_from_camera.translation.z;
  }
  return ground_m;
}

}  // namespace

behavior::FixJudgement JudgeWhileMapping(
    const core::RelocalizationAnswer& answer,
    const geometry::Rigid3& map_from_base,
    const geometry::Rotation3& level_from_base,
    const std::vector<dataset::TimedPose>& driven,
    const LiveQuestionOptions& options) {
  behavior::FixWitnesses witnesses;
  behavior::FixJudgement judgement =
      behavior::JudgeFix(answer, witnesses, options.gate);
  if (behavior::IsRefused(judgement.verdict)) return judgement;
  witnesses.tilt_error_rad =
      behavior::TiltError_rad(map_from_base.rotation, level_from_base);
  const geometry::Vec3& at = map_from_base.translation;
  witnesses.ground = {.base_in_map = at,
                      .ground_m = GroundNear(at, options.near_m, driven)};
  return behavior::JudgeFix(answer, witnesses, options.gate);
}

void LiveQuestions::Tell(const mapping::OnlineMapper& mapper) {
  if (mapper.IsLost() == was_lost_) return;
  was_lost_ = mapper.IsLost();
  if (was_lost_) {
    options_.say(
        "The robot was carried off, or has lost its way: nothing is drawn "
        "until "
        "it is found. Drive it on, to where it has been");
    return;
  }
  server_->Cancel();
  const mapping::Carry carry = mapper.Carries().back();
  options_.say(absl::StrFormat(
      "Found after %.1f s%s",
      recording::SecondsBetween(carry.at, carry.found.value_or(carry.at)),
      carry.who == mapping::SegmentWitness::kServer
          ? ", by the server, and scans agree"
          : ", by scans alone"));
}

void LiveQuestions::Add(const core::RgbdFrame& frame,
                        const mapping::OnlineMapper& mapper) {
  Tell(mapper);
  if (!mapper.IsLost() || server_->IsAsking()) return;
  if (asked_.has_value() &&
      std::chrono::duration<double>(frame.stamp - *asked_).count() <
          options_.every_s) {
    return;
  }
  asked_ = frame.stamp;
  level_from_base_ = mapper.LevelFromBase();
  ++status_.asked;
  server_->Ask(frame, options_.timeout_s);
}

std::optional<recording::LogEvent> LiveQuestions::Step(
    mapping::OnlineMapper& mapper, const geometry::Rigid3& base_from_camera) {
  Tell(mapper);
  const auto answer = server_->TakeAnswer();
  if (!answer.has_value()) return std::nullopt;
  if (!answer->ok()) {
    if (!has_failed_) {
      options_.say(absl::StrCat("The server does not answer: ",
                                std::string(answer->status().message())));
    }
    has_failed_ = true;
    return std::nullopt;
  }
  has_failed_ = false;
  ++status_.answered;
  const core::RelocalizationAnswer& seen = **answer;
  const geometry::Rigid3 map_from_base =
      seen.map_from_camera * base_from_camera.Inverse();
  const behavior::FixJudgement judgement = JudgeWhileMapping(
      seen, map_from_base, level_from_base_, mapper.Trajectory(), options_);
  if (behavior::IsRefused(judgement.verdict)) return std::nullopt;
  if (!mapper.SuggestPlace(seen.stamp, map_from_base)) return std::nullopt;
  ++status_.suggested;
  return recording::LogEvent{.stamp = seen.stamp,
                             .text = mapping::SeenPlaceText(map_from_base)};
}

}  // namespace treeline::map_app

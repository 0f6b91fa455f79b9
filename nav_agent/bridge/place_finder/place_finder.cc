#include "nav_agent/bridge/place_finder/place_finder.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/behavior/relocalization_parameters.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/core/corrected_devices.h"

namespace treeline::place_finder {
namespace {

// Older pictures are of another moment than the robot's.
constexpr double kMaxPictureAge_s = 1;
// Whoever was told a place needs a moment until scans fit there.
constexpr double kAfterPlace_s = 3;
// What a calibration and a drawing may differ by (m, rad).
constexpr double kSameCamera_m = 0.02;
constexpr double kSameCamera_rad = 0.0175;

std::chrono::nanoseconds Seconds(double seconds) {
  return std::chrono::nanoseconds(static_cast<int64_t>(seconds * 1e9));
}

// Whether two views show different things, or one thing from elsewhere.
bool AreDifferentViews(const localization::TrackedMotion& a,
                       const localization::TrackedMotion& b) {
  const geometry::Rigid2 way = a.odom_from_base.Inverse() * b.odom_from_base;
  return std::abs(way.yaw_rad) >= behavior::kOtherView_rad ||
         geometry::Norm(way.translation) >= behavior::kSamePlace_m;
}

// The same covariance in another frame: translation and rotation turn alike.
geometry::PoseCovariance Turned(const geometry::Rotation3& target_from_source,
                                const geometry::PoseCovariance& covariance) {
  const std::array<double, 9> r = target_from_source.Matrix().m;
  geometry::PoseCovariance turned{};
  for (size_t i = 0; i < 36; ++i) {
    const size_t row = i / 6;
    const size_t column = i % 6;
    for (size_t j = 0; j < 9; ++j) {
      turned[i] +=
          r[3 * (row % 3) + j / 3] * r[3 * (column % 3) + j % 3] *
          covariance[6 * (row / 3 * 3 + j / 3) + column / 3 * 3 + j % 3];
    }
  }
  return turned;
}

}  // namespace

absl::Status PlaceFinderOptions::Validate() const {
  TL_RETURN_IF_ERROR(gate.Validate());
  TL_RETURN_IF_ERROR(
      base::CheckRange("answer_timeout_s", answer_timeout_s, 0.1, 60));
  TL_RETURN_IF_ERROR(base::CheckRange("ask_interval_s", ask_interval_s, 0, 60));
  TL_RETURN_IF_ERROR((core::SensorCorrection{.laser_delay_s = laser_delay_s,
                                             .camera_delay_s = camera.delay_s}
                          .Validate()));
  TL_RETURN_IF_ERROR(
      base::CheckRange("max_turn_radps", max_turn_radps, 0.01, 10));
  if (!geometry::IsFinite(map_from_world)) {
    return absl::InvalidArgumentError("map_from_world is not finite");
  }
  if (map_frame.empty() || base_frame.empty()) {
    return absl::InvalidArgumentError("map_frame and base_frame need names");
  }
  return absl::OkStatus();
}

const char* NeedName(Need need) {
  switch (need) {
    case Need::kNone:
      return "none";
    case Need::kNoPlaceYet:
      return "nobody knows the place yet";
    case Need::kLost:
      return "lost";
    case Need::kAsked:
      return "asked";
  }
  return "?";
}

PlaceFinder::PlaceFinder(core::RelocalizationPort& server,
                         const PlaceFinderOptions& options)
    : server_(server), options_(options), camera_(options.camera) {}

absl::Status PlaceFinder::Add(const messages::Odometry& odometry) {
  const int before = odometry_.restarts();
  TL_RETURN_IF_ERROR(odometry_.Add(odometry));
  if (odometry_.restarts() != before) BeginAnew();
  return absl::OkStatus();
}

void PlaceFinder::BeginAnew() {
  is_question_stale_ = question_motion_.has_value();
  pending_.Clear();
  scan_.reset();
  state_.has_scan = false;
  lost_.reset();
  state_.verdict.reset();
}

absl::Status PlaceFinder::Add(const messages::OccupancyGrid& map) {
  TL_ASSIGN_OR_RETURN(core::OccupancyGrid grid, agent_values::GridOf(map));
  TL_ASSIGN_OR_RETURN(map_, FlatMap::Make(std::move(grid)));
  lost_.reset();
  state_.has_map = true;
  return absl::OkStatus();
}

absl::Status PlaceFinder::Add(const messages::LaserScan& scan) {
  TL_ASSIGN_OR_RETURN(const core::RangeSensorInfo info,
                      agent_values::SensorInfoOf(scan));
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 base_from_laser,
                      frames_.Find(options_.base_frame, scan.header.frame_id));
  PlacedScan placed = {.scan = agent_values::ScanOf(scan),
                       .info = info,
                       .base_from_laser = base_from_laser,
                       .odom_from_base = {}};
  placed.scan.stamp -= core::DelayOf(options_.laser_delay_s);
  const auto motion =
      odometry_.At(placed.scan.stamp +
                   Seconds(0.5 * info.beam_interval_s * (info.beams - 1)));
  // A scan without its odometry, at the start, tells nothing.
  if (!motion.has_value()) return absl::OkStatus();
  placed.odom_from_base = motion->odom_from_base;
  const geometry::Vec3 up =
      motion->level_from_base.Inverse() * geometry::Vec3{0, 0, 1};
  placed.pitch_rad = std::atan2(-up.x, std::hypot(up.y, up.z));
  placed.roll_rad = std::atan2(up.y, up.z);
  if (scan_.has_value() && !(scan_->info == info)) lost_.reset();
  scan_ = std::move(placed);
  state_.has_scan = true;
  WatchForLoss();
  return absl::OkStatus();
}

std::optional<geometry::Rigid2> PlaceFinder::BelievedAt(
    base::MonotonicTime stamp) const {
  const auto motion = odometry_.At(stamp);
  const auto map_from_odom =
      frames_.Find(options_.map_frame, odometry_.frame());
  if (!motion.has_value() || !map_from_odom.ok()) return std::nullopt;
  return geometry::PlanarPose(*map_from_odom) * motion->odom_from_base;
}

void PlaceFinder::WatchForLoss() {
  const auto believed = BelievedAt(scan_->scan.stamp);
  has_place_ |= believed.has_value();
  if (!map_.has_value() || !believed.has_value()) return;
  if (!lost_.has_value()) {
    auto made = localization::LostDetector::Create(
        localization::LaserMap::AllOpaque(map_->grid()), scan_->info,
        scan_->base_from_laser, {});
    if (!made.ok()) return;
    lost_ = *std::move(made);
  }
  localization::LostEvidence evidence;
  evidence.stamp = scan_->scan.stamp;
  evidence.estimate.map_from_base = *believed;
  // Who believes it does not say how sure it is.
  evidence.estimate.share = 1;
  evidence.odom_from_base = scan_->odom_from_base;
  evidence.pitch_rad = scan_->pitch_rad;
  evidence.roll_rad = scan_->roll_rad;
  if (auto verdict = lost_->Observe(evidence, scan_->scan); verdict.ok()) {
    state_.verdict = *std::move(verdict);
  }
}

Need PlaceFinder::NeedNow() const {
  if (is_asked_) return Need::kAsked;
  if (!has_place_) return Need::kNoPlaceYet;
  if (state_.verdict.has_value() &&
      state_.verdict->state == localization::LostState::kLost) {
    return Need::kLost;
  }
  return Need::kNone;
}

PlaceFinder::Output PlaceFinder::Step(base::MonotonicTime now) {
  Output output;
  has_place_ |= !odometry_.empty() &&
                frames_.Find(options_.map_frame, odometry_.frame()).ok();
  TakeAnswer(now, output);
  const Need need = NeedNow();
  if (need != state_.need) {
    output.events.push_back(absl::StrCat("need: ", NeedName(need)));
    if (need == Need::kNone) pending_.Clear();
    state_.need = need;
  }
  if (need == Need::kNone || question_motion_.has_value()) return output;
  // A clock that went back makes nobody wait longer.
  if (next_question_.has_value() && now < *next_question_ &&
      *next_question_ - now <=
          Seconds(std::max(options_.ask_interval_s, kAfterPlace_s))) {
    return output;
  }
  const std::string disputed = state_.camera_dispute;
  const absl::Status obstacle = AskIfPossible(now);
  if (!state_.camera_dispute.empty() && disputed.empty()) {
    output.events.push_back(state_.camera_dispute);
  }
  if (obstacle != state_.obstacle && !obstacle.ok()) {
    output.events.push_back(
        absl::StrCat("cannot ask: ", std::string(obstacle.message())));
  }
  state_.obstacle = obstacle;
  return output;
}

absl::Status PlaceFinder::AskIfPossible(base::MonotonicTime now) {
  if (odometry_.empty()) {
    return absl::FailedPreconditionError("no odometry has come");
  }
  const auto stamp = camera_.NewestStamp();
  if (!stamp.has_value()) return camera_.Newest().status();
  // Of a picture that was asked about already, nothing new comes.
  if (camera_.pictures() - 1 <= last_asked_picture_) return absl::OkStatus();
  const double age_s = base::SecondsBetween(*stamp, now);
  if (std::abs(age_s) > kMaxPictureAge_s) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "the newest picture is of another time than this clock's, by %s; with "
        "a simulated clock use use_sim_time",
        std::abs(age_s) < 3600 ? absl::StrFormat("%.0f s", age_s)
                               : std::string("hours")));
  }
  const auto motion = odometry_.At(*stamp);
  if (!motion.has_value()) {
    return absl::FailedPreconditionError(
        "there is no odometry of the picture's moment: its stamps must be of "
        "the same clock");
  }
  if (std::abs(motion->yaw_rate_radps) > options_.max_turn_radps) {
    return absl::FailedPreconditionError("the robot turns too fast");
  }
  TL_RETURN_IF_ERROR(FindCamera());
  TL_ASSIGN_OR_RETURN(const core::RgbdFrame frame, camera_.Newest());
  last_asked_picture_ = frame.sequence;
  question_motion_ = motion;
  is_question_stale_ = false;
  ++state_.questions;
  server_.Ask(frame, options_.answer_timeout_s);
  return absl::OkStatus();
}

absl::Status PlaceFinder::FindCamera() {
  if (!options_.base_from_camera.has_value()) {
    TL_ASSIGN_OR_RETURN(base_from_camera_,
                        frames_.Find(options_.base_frame, camera_.frame_id()));
    return absl::OkStatus();
  }
  base_from_camera_ = *options_.base_from_camera;
  state_.camera_dispute = CameraDispute();
  return absl::OkStatus();
}

std::string PlaceFinder::CameraDispute() const {
  const auto by_tf = frames_.Find(options_.base_frame, camera_.frame_id());
  if (!by_tf.ok()) return "";
  const double off_m = geometry::Norm(by_tf->translation -
                                      options_.base_from_camera->translation);
  const double off_rad = geometry::AngleBetween_rad(
      by_tf->rotation, options_.base_from_camera->rotation);
  if (off_m <= kSameCamera_m && off_rad <= kSameCamera_rad) return "";
  return absl::StrFormat(
      "the camera (%s) is %.1f cm and %.1f degrees from where /tf has it: goes "
      "by what it was told; other nodes go by /tf",
      camera_.frame_id(), 100 * off_m, off_rad * 180 / std::numbers::pi);
}

void PlaceFinder::TakeAnswer(base::MonotonicTime now, Output& output) {
  if (!question_motion_.has_value()) return;
  const auto answer = server_.TakeAnswer();
  if (!answer.has_value()) return;
  next_question_ = now + Seconds(options_.ask_interval_s);
  const localization::TrackedMotion motion = *question_motion_;
  question_motion_.reset();
  if (answer->status() != state_.last_answer && !answer->ok()) {
    output.events.push_back(
        absl::StrCat("server: ", answer->status().ToString()));
  }
  state_.last_answer = answer->status();
  if (!answer->ok()) return;
  ++state_.answers;
  state_.last_round_trip_s = (*answer)->round_trip_s;
  if (is_question_stale_) {
    output.events.push_back("an answer of before the clock began anew");
    return;
  }
  const behavior::GatedFix fix = Check(**answer, motion);
  state_.last_fix = behavior::FixText(fix);
  output.events.push_back(absl::StrCat("fix: ", state_.last_fix));
  if (behavior::IsRefused(fix.verdict)) ++state_.refused;
  if (const auto taken = Decide(fix)) Publish(*taken, now, output);
}

behavior::GatedFix PlaceFinder::Check(
    const core::RelocalizationAnswer& answer,
    const localization::TrackedMotion& motion) const {
  core::RelocalizationAnswer in_map = answer;
  in_map.map_from_camera = options_.map_from_world * answer.map_from_camera;
  in_map.covariance =
      Turned(options_.map_from_world.rotation, answer.covariance);
  behavior::GatedFix fix;
  fix.motion = motion;
  fix.confidence = answer.confidence;
  fix.log_odds = behavior::LogOddsOf(answer.confidence);
  fix.is_server_sure = behavior::IsServerSure(answer, options_.gate);
  behavior::FixWitnesses witnesses;
  const auto judge = [&] {
    behavior::FixJudgement judgement =
        behavior::JudgeFix(in_map, witnesses, options_.gate);
    fix.verdict = judgement.verdict;
    fix.why = std::move(judgement.why);
    return behavior::IsRefused(fix.verdict);
  };
  if (judge()) return fix;
  const geometry::Rigid3 map_from_base =
      in_map.map_from_camera * base_from_camera_.Inverse();
  witnesses.tilt_error_rad =
      behavior::TiltError_rad(map_from_base.rotation, motion.level_from_base);
  if (judge()) return fix;
  fix.pose.map_from_base = geometry::PlanarPose(map_from_base);
  fix.covariance = behavior::FixCovariance(in_map.covariance);
  behavior::GroundWitness ground = {.base_in_map = map_from_base.translation,
                                    .ground_m = 0.0};
  const geometry::Vec2 at = fix.pose.map_from_base.translation;
  if (map_.has_value() &&
      map_->Clearance_m(at) < options_.gate.min_clearance_m) {
    ground.ground_m = std::nullopt;
  }
  witnesses.ground = ground;
  if (judge() || !map_.has_value() || !scan_.has_value()) return fix;
  // The scan was taken at another moment than the picture.
  const geometry::Rigid2 frame_from_scan =
      motion.odom_from_base.Inverse() * scan_->odom_from_base;
  const auto best = map_->BestNear(
      *scan_, fix.pose.map_from_base * frame_from_scan, options_.gate);
  behavior::ScanWitness witness;
  if (best.has_value()) {
    witness.at_fix = best->fit;
    fix.fit = best->fit;
    fix.pose.map_from_base =
        best->pose.map_from_base * frame_from_scan.Inverse();
    if (const auto believed = BelievedAt(scan_->scan.stamp);
        believed.has_value() &&
        geometry::Norm(believed->translation -
                       best->pose.map_from_base.translation) >
            behavior::kSamePlace_m) {
      witness.at_belief = map_->FitOf(*scan_, *believed);
    }
  }
  witnesses.scan = witness;
  judge();
  return fix;
}

std::optional<behavior::GatedFix> PlaceFinder::Decide(
    const behavior::GatedFix& fix) {
  state_.is_server_elsewhere = false;
  if (!behavior::IsRefused(fix.verdict)) {
    const auto other = pending_.TakeFirst([&](const behavior::GatedFix& one) {
      return behavior::FixesAgree(one, fix, options_.gate) &&
             AreDifferentViews(one.motion, fix.motion);
    });
    if (other.has_value()) {
      const behavior::GatedFix both = behavior::CombinedFix(*other, fix);
      if (behavior::AreViewsSure(both)) return both;
    }
    if (options_.is_one_view_enough && fix.is_server_sure) return fix;
  }
  const behavior::PendingFixes::Result result = pending_.Add(
      fix, options_.gate, fix.verdict == behavior::FixVerdict::kSure, false);
  switch (result.decision) {
    case behavior::FixDecision::kTake:
      return result.fix;
    case behavior::FixDecision::kTakeAgreed:
      // From one place, both may err alike; the laser tells.
      if (fix.verdict == behavior::FixVerdict::kSure) return result.fix;
      return std::nullopt;
    case behavior::FixDecision::kServerIsLost:
      state_.is_server_elsewhere = true;
      return std::nullopt;
    case behavior::FixDecision::kLookOn:
      return std::nullopt;
  }
  return std::nullopt;
}

void PlaceFinder::Publish(const behavior::GatedFix& fix,
                          base::MonotonicTime now, Output& output) {
  const localization::TrackedMotion& newest = odometry_.newest();
  const geometry::Rigid2 map_from_base =
      fix.pose.map_from_base *
      (fix.motion.odom_from_base.Inverse() * newest.odom_from_base);
  messages::PoseWithCovarianceStamped message;
  message.header = {.stamp = conversions::StampOf(newest.stamp),
                    .frame_id = options_.map_frame};
  message.pose.pose = conversions::PoseOf(
      {.rotation =
           geometry::Rotation3::FromAxisAngle({0, 0, map_from_base.yaw_rad}),
       .translation = {map_from_base.translation.x, map_from_base.translation.y,
                       0}});
  // x, y and rotation about z, in the order of PoseWithCovariance.
  constexpr std::array<size_t, 3> kWhere = {0, 1, 5};
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 3; ++column) {
      message.pose.covariance[6 * kWhere[row] + kWhere[column]] =
          fix.covariance[3 * row + column];
    }
  }
  output.initial_pose = std::move(message);
  output.events.push_back(
      absl::StrFormat("place: %.2f, %.2f, %.0f degrees",
                      map_from_base.translation.x, map_from_base.translation.y,
                      map_from_base.yaw_rad * 180 / std::numbers::pi));
  ++state_.places;
  is_asked_ = false;
  has_place_ = true;
  pending_.Clear();
  if (lost_.has_value()) lost_->Reset();
  state_.verdict.reset();
  next_question_ = now + Seconds(kAfterPlace_s);
}

}  // namespace treeline::place_finder

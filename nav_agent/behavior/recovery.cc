#include "nav_agent/behavior/recovery.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline {
namespace {

// Wheels that turn slower than this stand.
constexpr double kStands_mps = 0.01;
constexpr double kStands_radps = 0.02;
// A robot that does not come to stand, or whose camera is silent (s).
constexpr double kMostStopping_s = 5;
constexpr double kMostLooking_s = 2.5;
// The port's own deadline and a bit (s).
constexpr double kLate_s = 0.5;
// A turn ends this near to where it should (rad), or after so long (s).
constexpr double kTurned_rad = 0.05;
constexpr double kMostTurning_s = 12;
// Without room to turn, it gives up after this (s).
constexpr double kMostStuck_s = 4;
// Directions that promise less are not looked at.
constexpr double kLeastPromise = 0.06;
// Of scans while confirming: more bad ones end it.
constexpr int kMostBadScans = 12;
// The pose must not leave what was seeded by more (m).
constexpr double kMostDrift_m = 0.6;
constexpr size_t kMostWaiting = 8;

double SecondsBetween(MonotonicTime from, MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
}

LevelPose CarriedOn(const LevelPose& pose, const TrackedMotion& from,
                    const TrackedMotion& to, const NavigationMap& map) {
  LevelPose carried = pose;
  carried.map_from_base =
      pose.map_from_base * (from.odom_from_base.Inverse() * to.odom_from_base);
  carried.place =
      map.GroundNear(carried.map_from_base.translation, pose.place.height_m)
          .value_or(pose.place);
  return carried;
}

const char* CauseText(RecoveryCause cause) {
  switch (cause) {
    case RecoveryCause::kVerdict:
      return "the robot is lost";
    case RecoveryCause::kStart:
      return "nobody has told the robot where it is";
    case RecoveryCause::kPerson:
      return "a person asked where the robot is";
    case RecoveryCause::kCheck:
      return "the server sees the robot elsewhere";
  }
  return "?";
}

}  // namespace

Recovery::Recovery(std::shared_ptr<const NavigationMap> map,
                   const RobotModel& robot, RobotTracker& tracker,
                   RelocalizationPort* server,
                   const LostAndFoundOptions& options)
    : map_(map),
      tracker_(tracker),
      server_(options.method == RecoveryMethod::kServer ? server : nullptr),
      options_(options),
      gate_(std::move(map), robot, options.gate) {}

void Recovery::AddFrame(const RgbdFrame& frame) {
  frame_ = std::make_shared<const RgbdFrame>(frame);
}

void Recovery::Go(RecoveryState state, MonotonicTime now) {
  state_ = state;
  since_ = now;
  stands_.reset();
}

double Recovery::InState_s(MonotonicTime now) const {
  return SecondsBetween(since_, now);
}

void Recovery::Note(const char* kind, std::string text) {
  notes_.push_back({.kind = kind, .text = std::move(text)});
}

std::vector<RecoveryNote> Recovery::TakeNotes() {
  return std::exchange(notes_, {});
}

void Recovery::Begin(RecoveryCause cause, MonotonicTime now) {
  if (server_ != nullptr) server_->Cancel();
  is_checking_ = false;
  asked_motion_.reset();
  cause_ = cause;
  began_ = now;
  questions_ = 0;
  failures_ = 0;
  server_is_useless_ = false;
  waiting_.clear();
  seed_.reset();
  before_ = tracker_.Pose();
  before_motion_ = tracker_.Motion();
  was_seeded_ = false;
  search_began_.reset();
  searches_anywhere_ = false;
  belief_ = ViewBelief();
  std::string text = CauseText(cause);
  if (cause == RecoveryCause::kVerdict) {
    absl::StrAppend(&text, ": ", LostReasonName(tracker_.verdict().reason));
  }
  Note("lost", std::move(text));
  Go(RecoveryState::kStopping, now);
}

void Recovery::WasTold(MonotonicTime now) {
  if (server_ != nullptr) server_->Cancel();
  asked_motion_.reset();
  is_checking_ = false;
  if (IsActive()) Note("recovery", "it was told where it is");
  Go(RecoveryState::kIdle, now);
}

bool Recovery::MayAsk() const {
  return server_ != nullptr && !server_is_useless_ &&
         questions_ < options_.max_questions;
}

void Recovery::Ask(const TrackedMotion& motion, MonotonicTime now) {
  query_frame_ = frame_;
  asked_motion_ = motion;
  asked_ = now;
  server_->Ask(*query_frame_, options_.deadline_s);
}

std::optional<Recovery::Answer> Recovery::AnswerBy(MonotonicTime now) {
  std::optional<Answer> answer = server_->TakeAnswer();
  if (!answer.has_value() &&
      SecondsBetween(asked_, now) > options_.deadline_s + kLate_s) {
    server_->Cancel();
    answer = Answer(absl::DeadlineExceededError("no answer in time"));
  }
  return answer;
}

LostAndFound::Output Recovery::Step(const RecoveryInput& input) {
  const MonotonicTime now = input.now;
  if (state_ == RecoveryState::kFound) Go(RecoveryState::kIdle, now);
  if (state_ == RecoveryState::kIdle) Idle(input);
  VelocityCommand wanted;
  switch (state_) {
    case RecoveryState::kIdle:
    case RecoveryState::kFound:
    case RecoveryState::kNeedHelp:
      break;
    case RecoveryState::kStopping:
      wanted = Stopping(now);
      break;
    case RecoveryState::kLooking:
      wanted = Looking(now);
      break;
    case RecoveryState::kAsking:
      wanted = Asking(input);
      break;
    case RecoveryState::kTurning:
      wanted = Turning(input);
      break;
    case RecoveryState::kConfirming:
      wanted = Confirming(input);
      break;
    case RecoveryState::kSearching:
      wanted = Searching(input);
      break;
  }
  return {.state = state_, .wanted = wanted};
}

VelocityCommand Recovery::Stopping(MonotonicTime now) {
  const std::optional<TrackedMotion> motion = tracker_.Motion();
  const bool stands = motion.has_value() &&
                      std::abs(motion->forward_mps) < kStands_mps &&
                      std::abs(motion->yaw_rate_radps) < kStands_radps;
  if (!stands) {
    stands_.reset();
  } else if (!stands_.has_value()) {
    stands_ = now;
  }
  const bool has_settled =
      stands_.has_value() && SecondsBetween(*stands_, now) >= options_.settle_s;
  if (!has_settled && InState_s(now) < kMostStopping_s) return {};
  if (!belief_.has_begun() && motion.has_value()) {
    belief_.Begin(motion->odom_from_base);
  }
  if (MayAsk()) {
    Go(RecoveryState::kLooking, now);
  } else {
    GiveUpServer(server_ == nullptr ? "there is no server to ask"
                                    : "the server was asked often enough",
                 now);
  }
  return {};
}

VelocityCommand Recovery::Looking(MonotonicTime now) {
  const bool is_new = frame_ != nullptr && frame_->stamp >= since_;
  if (!is_new) {
    if (InState_s(now) > kMostLooking_s) {
      GiveUpServer("the camera gives no pictures", now);
    }
    return {};
  }
  const std::optional<TrackedMotion> motion = tracker_.MotionAt(frame_->stamp);
  // The wheels of that moment come a little later.
  if (!motion.has_value()) return {};
  belief_.AddScan(motion->odom_from_base, tracker_.ScanInBase());
  ++questions_;
  Ask(*motion, now);
  Go(RecoveryState::kAsking, now);
  return {};
}

VelocityCommand Recovery::Asking(const RecoveryInput& input) {
  const std::optional<Answer> answer = AnswerBy(input.now);
  if (!answer.has_value()) return {};
  if (!answer->ok()) {
    Failed(answer->status(), input.now);
  } else {
    Judge(**answer, input.now);
  }
  return {};
}

void Recovery::Failed(const absl::Status& status, MonotonicTime now) {
  ++failures_;
  answer_verdict_ = std::string(status.ToString());
  Note("fix", absl::StrCat("the server did not answer: ", answer_verdict_));
  if (absl::IsNotFound(status)) {
    server_is_useless_ = true;
    GiveUpServer("the server does not know this scene", now);
  } else if (failures_ >= options_.max_failures || search_began_.has_value()) {
    GiveUpServer("the server does not answer", now);
  } else {
    // Once more, with a new picture.
    Go(RecoveryState::kStopping, now);
  }
}

void Recovery::Judge(const RelocalizationAnswer& answer, MonotonicTime now) {
  failures_ = 0;
  const GatedFix fix = gate_.Check(answer, *asked_motion_, tracker_);
  answer_ = answer;
  answer_verdict_ = absl::StrCat(FixVerdictName(fix.verdict),
                                 fix.why.empty() ? "" : ": ", fix.why);
  Note("fix", answer_verdict_);
  const double yaw_rad = asked_motion_->odom_from_base.yaw_rad;
  if (IsRefused(fix.verdict)) {
    const bool is_near = fix.verdict == FixVerdict::kLowConfidence;
    belief_.AddAnswer(yaw_rad, is_near ? answer.confidence : 0.03);
    LookElsewhere(now);
    return;
  }
  belief_.AddAnswer(yaw_rad, fix.confidence);
  const auto agrees = std::ranges::find_if(
      waiting_, [&](const GatedFix& other) { return gate_.Agree(other, fix); });
  if (agrees != waiting_.end()) {
    Note("fix", "two views agree");
    Seed(fix, true, now);
    return;
  }
  if (fix.verdict == FixVerdict::kSure && waiting_.empty() &&
      cause_ != RecoveryCause::kCheck) {
    Seed(fix, false, now);
    return;
  }
  if (waiting_.size() >= kMostWaiting) waiting_.erase(waiting_.begin());
  waiting_.push_back(fix);
  LookElsewhere(now);
}

void Recovery::LookElsewhere(MonotonicTime now) {
  if (search_began_.has_value()) {
    Go(RecoveryState::kSearching, now);
    return;
  }
  const std::optional<TrackedMotion> motion = tracker_.Motion();
  const bool has_time = SecondsBetween(began_, now) < options_.most_server_s;
  if (!MayAsk() || !has_time || !motion.has_value()) {
    GiveUpServer("no answer of the server could be believed", now);
    return;
  }
  std::optional<double> near_rad;
  if (!waiting_.empty()) {
    near_rad = waiting_.back().motion.odom_from_base.yaw_rad;
  }
  const std::optional<double> next_rad =
      belief_.Next(motion->odom_from_base.yaw_rad, near_rad, kLeastPromise);
  if (!next_rad.has_value()) {
    GiveUpServer("no direction is left that promises anything", now);
    return;
  }
  target_rad_ = *next_rad;
  Go(RecoveryState::kTurning, now);
}

VelocityCommand Recovery::TurnTowards(double yaw_in_odom_rad) const {
  const std::optional<TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return {};
  const double left_rad =
      NormalizedAngle_rad(yaw_in_odom_rad - motion->odom_from_base.yaw_rad);
  const double speed_radps =
      std::clamp(2 * std::abs(left_rad), 0.12, options_.turn_radps);
  return {.forward_mps = 0,
          .yaw_rate_radps = std::copysign(speed_radps, left_rad)};
}

VelocityCommand Recovery::MakeRoom(const RecoveryInput& input) const {
  constexpr double kRoom_m = 0.25;
  if (input.free_ahead_m >= kRoom_m &&
      input.free_ahead_m >= input.free_behind_m) {
    return {.forward_mps = options_.move_mps, .yaw_rate_radps = 0};
  }
  if (input.free_behind_m >= kRoom_m) {
    return {.forward_mps = -options_.move_mps, .yaw_rate_radps = 0};
  }
  return {};
}

VelocityCommand Recovery::Turning(const RecoveryInput& input) {
  const std::optional<TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return {};
  belief_.AddScan(motion->odom_from_base, tracker_.ScanInBase());
  const double left_rad =
      NormalizedAngle_rad(target_rad_ - motion->odom_from_base.yaw_rad);
  const double took_s = InState_s(input.now);
  if (std::abs(left_rad) < kTurned_rad || took_s > kMostTurning_s) {
    Go(RecoveryState::kStopping, input.now);
    return {};
  }
  if (input.can_turn) return TurnTowards(target_rad_);
  const VelocityCommand room = MakeRoom(input);
  if (room == VelocityCommand() && took_s > kMostStuck_s) {
    GiveUpServer("there is no room to turn", input.now);
  }
  return room;
}

void Recovery::Seed(const GatedFix& fix, bool was_seen_twice,
                    MonotonicTime now) {
  const std::optional<TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return;
  const LevelPose pose = CarriedOn(fix.pose, fix.motion, *motion, *map_);
  const absl::Status told = tracker_.SetPose(pose, fix.covariance, now);
  if (!told.ok()) {
    Note("fix", absl::StrCat("the fix could not be taken: ",
                             std::string(told.ToString())));
    LookElsewhere(now);
    return;
  }
  was_seeded_ = true;
  seed_ = fix;
  seen_twice_ = was_seen_twice;
  good_scans_ = 0;
  bad_scans_ = 0;
  turned_rad_ = 0;
  last_yaw_rad_.reset();
  scan_ = tracker_.ScanStamp();
  alias_ = Alias::kNotLooked;
  Note("recovery",
       absl::StrFormat("takes %.2f, %.2f on level %d, %.0f degrees, to see "
                       "whether it holds",
                       pose.map_from_base.translation.x,
                       pose.map_from_base.translation.y, pose.place.level,
                       pose.map_from_base.yaw_rad * 57.29577951308232));
  Go(RecoveryState::kConfirming, now);
}

Recovery::ScanSays Recovery::WatchScan(double explained, double contradicted) {
  const std::optional<MonotonicTime> stamp = tracker_.ScanStamp();
  if (!stamp.has_value() || stamp == scan_) return ScanSays::kNothingNew;
  scan_ = stamp;
  const std::optional<TrackedPose> pose = tracker_.PoseAt(*stamp);
  if (!pose.has_value()) return ScanSays::kNothingNew;
  const auto fit = tracker_.FitAt(pose->pose);
  if (!fit.has_value() || fit->judged < options_.gate.least_judged / 2) {
    return ScanSays::kNothingNew;
  }
  return fit->explained >= explained && fit->contradicted <= contradicted
             ? ScanSays::kGood
             : ScanSays::kBad;
}

bool Recovery::IsPoseTight(double share, double std_m) const {
  const std::optional<TrackedPose> pose = tracker_.Pose();
  return pose.has_value() && pose->share >= share && !pose->is_searching &&
         std::sqrt(std::max(pose->covariance[0], pose->covariance[4])) <= std_m;
}

bool Recovery::IsAmbiguous() const {
  const auto other = tracker_.BestOtherPlace();
  if (!other.has_value()) return false;
  const double own = alias_own_.explained - alias_own_.contradicted;
  return other->fit.explained - other->fit.contradicted >
         own - options_.alias_margin;
}

VelocityCommand Recovery::Confirming(const RecoveryInput& input) {
  const std::optional<TrackedMotion> motion = tracker_.Motion();
  const std::optional<TrackedPose> pose = tracker_.Pose();
  if (!motion.has_value() || !pose.has_value()) return {};
  const double yaw_rad = motion->odom_from_base.yaw_rad;
  if (last_yaw_rad_.has_value()) {
    turned_rad_ += std::abs(NormalizedAngle_rad(yaw_rad - *last_yaw_rad_));
  }
  last_yaw_rad_ = yaw_rad;
  switch (
      WatchScan(options_.confirm_explained, options_.confirm_contradicted)) {
    case ScanSays::kNothingNew:
      break;
    case ScanSays::kGood:
      ++good_scans_;
      break;
    case ScanSays::kBad:
      good_scans_ = 0;
      ++bad_scans_;
      break;
  }
  // Whether the laser alone would know this place from all others.
  if (alias_ == Alias::kNotLooked && good_scans_ > 0) {
    const auto fit = tracker_.FitAt(pose->pose);
    alias_own_ = fit.value_or(RobotTracker::ScanFit());
    tracker_.BeginOtherPlaces(pose->pose);
    alias_ = Alias::kLooking;
  } else if (alias_ == Alias::kLooking && tracker_.StepOtherPlaces()) {
    alias_ = IsAmbiguous() ? Alias::kSome : Alias::kNone;
  }
  const LevelPose expected =
      CarriedOn(seed_->pose, seed_->motion, *motion, *map_);
  const double drift_m = Norm(expected.map_from_base.translation -
                              pose->pose.map_from_base.translation);
  const LostVerdict& verdict = tracker_.verdict();
  if (bad_scans_ > kMostBadScans || drift_m > kMostDrift_m ||
      verdict.state == LostState::kLost) {
    NotConfirmed(drift_m > kMostDrift_m ? "localization went elsewhere"
                                        : "scans do not fit there",
                 input.now);
    return {};
  }
  const bool has_held = good_scans_ >= options_.confirm_scans &&
                        turned_rad_ >= options_.confirm_turn_rad &&
                        IsPoseTight(0.8, 0.3) && verdict.probability < 0.3;
  if (has_held && (seen_twice_ || alias_ == Alias::kNone)) {
    Found(seen_twice_ ? "seen twice, and scans fit"
                      : "seen once, and scans fit nowhere else",
          input.now);
    return {};
  }
  if (has_held && alias_ == Alias::kSome) {
    // Other places look the same to the laser: the camera must say it twice.
    Note("recovery", "the laser would fit elsewhere too: looks a second time");
    waiting_ = {*seed_};
    if (MayAsk()) {
      Go(RecoveryState::kStopping, input.now);
    } else {
      NotConfirmed("places look alike, and the server cannot be asked again",
                   input.now);
    }
    return {};
  }
  if (InState_s(input.now) > options_.most_confirm_s) {
    NotConfirmed("it was not confirmed in time", input.now);
    return {};
  }
  if (turned_rad_ >= options_.confirm_turn_rad) return {};
  if (!input.can_turn) return MakeRoom(input);
  return {.forward_mps = 0, .yaw_rate_radps = 0.6 * options_.turn_radps};
}

void Recovery::NotConfirmed(const std::string& why, MonotonicTime now) {
  Note("recovery", absl::StrCat("not there: ", why));
  answer_verdict_ = absl::StrCat("taken, and not confirmed: ", why);
  waiting_.clear();
  if (seed_.has_value()) {
    belief_.AddAnswer(seed_->motion.odom_from_base.yaw_rad, 0.03);
  }
  seed_.reset();
  if (search_began_.has_value()) {
    searches_anywhere_ = false;
    cycles_ = 1;
    Go(RecoveryState::kSearching, now);
    return;
  }
  LookElsewhere(now);
}

void Recovery::Found(const std::string& how, MonotonicTime now) {
  const std::optional<TrackedPose> pose = tracker_.Pose();
  Note("resume",
       absl::StrFormat("found after %.1f s and %d questions (%s): %.2f, %.2f "
                       "on level %d",
                       SecondsBetween(began_, now), questions_, how,
                       pose->pose.map_from_base.translation.x,
                       pose->pose.map_from_base.translation.y,
                       pose->pose.place.level));
  last_check_ = now;
  Go(RecoveryState::kFound, now);
}

void Recovery::RestoreBefore(MonotonicTime now) {
  const std::optional<TrackedMotion> motion = tracker_.Motion();
  if (!was_seeded_ || !before_.has_value() || !before_motion_.has_value() ||
      !motion.has_value()) {
    return;
  }
  was_seeded_ = false;
  PoseCovariance2 covariance = before_->covariance;
  for (const size_t i : {size_t{0}, size_t{4}, size_t{8}}) {
    covariance[i] += 0.01;
  }
  tracker_
      .SetPose(CarriedOn(before_->pose, *before_motion_, *motion, *map_),
               covariance, now)
      .IgnoreError();
}

void Recovery::GiveUpServer(const std::string& why, MonotonicTime now) {
  if (server_ != nullptr) server_->Cancel();
  if (search_began_.has_value()) {
    Go(RecoveryState::kSearching, now);
    return;
  }
  RestoreBefore(now);
  if (cause_ == RecoveryCause::kCheck) {
    // Nobody said so but one picture: it stays where it was.
    Note("check", absl::StrCat("it stays where it thought it was: ", why));
    Go(RecoveryState::kIdle, now);
    return;
  }
  Note("recovery", absl::StrCat(why, ": looks for its place by laser"));
  BeginSearch(now);
}

void Recovery::NeedHelp(MonotonicTime now) {
  Note("help",
       "nobody found the robot's place: say where it is (initial pose), or "
       "drive it to where the map looks like nothing else");
  Go(RecoveryState::kNeedHelp, now);
}

}  // namespace treeline

#include "nav_agent/behavior/recovery.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/behavior/recovery_parts.h"

namespace treeline::behavior {
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
constexpr double kTurned_rad = 0.1;
constexpr double kMostTurning_s = 12;
// What has not turned after this (s) has no room to.
constexpr double kMostStuck_s = 1.5;
// It swings back when it has not turned for so long (s). Where it turns to
// neither side it goes a little ahead, if there is this much room (m), until so
// many tries have failed.
constexpr double kSwingBlocked_s = 0.6;
constexpr double kRoom_m = 0.25;
constexpr int kMostSidesBlocked = 8;
// From where something held it there (m), it keeps away so far (rad).
constexpr double kSamePlace_m = 0.15;
constexpr double kKeepFrom_rad = 0.15;
// Directions that promise less are not looked at.
constexpr double kLeastPromise = 0.06;
// So many fixes in a row that the server is sure of and the robot's own sensors
// refuse: the server knows another place than this one.
constexpr int kMostRefused = 3;
// An answer is waited for standing while it may come any moment (s).
constexpr double kPatience_s = 1;
constexpr size_t kMostWaiting = 8;
// Views that show something else are turned by this (rad). Together they are
// sure from 99 in 100 on.
constexpr double kOtherView_rad = 0.3;
constexpr double kSureLogOdds = 4.6;

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

Recovery::Recovery(std::shared_ptr<const traversability::NavigationMap> map,
                   const core::RobotModel& robot,
                   localization::RobotTracker& tracker,
                   core::RelocalizationPort* server,
                   const LostAndFoundOptions& options)
    : map_(map),
      tracker_(tracker),
      server_(options.method == RecoveryMethod::kServer ? server : nullptr),
      options_(options),
      gate_(std::move(map), robot, options.gate) {}

void Recovery::AddFrame(const core::RgbdFrame& frame) {
  frame_ = std::make_shared<const core::RgbdFrame>(frame);
}

void Recovery::Go(RecoveryState state, base::MonotonicTime now) {
  state_ = state;
  since_ = now;
  stands_.reset();
}

double Recovery::InState_s(base::MonotonicTime now) const {
  return SecondsBetween(since_, now);
}

void Recovery::Note(const char* kind, std::string text) {
  notes_.push_back({.kind = kind, .text = std::move(text)});
}

std::vector<RecoveryNote> Recovery::TakeNotes() {
  return std::exchange(notes_, {});
}

void Recovery::Begin(RecoveryCause cause, base::MonotonicTime now) {
  if (server_ != nullptr) server_->Cancel();
  is_checking_ = false;
  asked_motion_.reset();
  cause_ = cause;
  began_ = now;
  questions_ = 0;
  failures_ = 0;
  refused_ = 0;
  server_is_useless_ = false;
  needs_help_ = false;
  waiting_.clear();
  seed_.reset();
  held_at_ = {};
  look_ = Look::kNone;
  clear_.reset();
  clear_was_tried_ = false;
  before_ = tracker_.Pose();
  before_motion_ = tracker_.Motion();
  was_seeded_ = false;
  search_began_.reset();
  searches_anywhere_ = false;
  belief_ = ViewBelief();
  std::string text = CauseText(cause);
  if (cause == RecoveryCause::kVerdict) {
    absl::StrAppend(&text, ": ",
                    localization::LostReasonName(tracker_.verdict().reason));
  }
  Note("lost", std::move(text));
  Go(RecoveryState::kStopping, now);
}

void Recovery::WasTold(base::MonotonicTime now) {
  if (server_ != nullptr) server_->Cancel();
  asked_motion_.reset();
  is_checking_ = false;
  needs_help_ = false;
  look_ = Look::kNone;
  if (IsActive()) Note("recovery", "it was told where it is");
  CheckSoon(now);
  Go(RecoveryState::kIdle, now);
}

bool Recovery::MayAsk() const {
  return server_ != nullptr && !server_is_useless_ &&
         questions_ < options_.max_questions;
}

void Recovery::Ask(const localization::TrackedMotion& motion,
                   base::MonotonicTime now) {
  query_frame_ = frame_;
  asked_motion_ = motion;
  asked_ = now;
  asks_ = true;
  server_->Ask(*query_frame_, options_.deadline_s);
}

std::optional<Recovery::Answer> Recovery::AnswerBy(base::MonotonicTime now) {
  std::optional<Answer> answer = server_->TakeAnswer();
  if (!answer.has_value() &&
      SecondsBetween(asked_, now) > options_.deadline_s + kLate_s) {
    server_->Cancel();
    answer = Answer(absl::DeadlineExceededError("no answer in time"));
  }
  return answer;
}

LostAndFound::Output Recovery::Step(const RecoveryInput& input) {
  const base::MonotonicTime now = input.now;
  if (state_ == RecoveryState::kFound) Go(RecoveryState::kIdle, now);
  if (state_ == RecoveryState::kIdle) Idle(input);
  StepLook(now);
  core::VelocityCommand wanted;
  switch (state_) {
    case RecoveryState::kIdle:
    case RecoveryState::kFound:
      break;
    case RecoveryState::kNeedHelp:
      Helpless(now);
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

core::VelocityCommand Recovery::Stopping(base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
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

core::VelocityCommand Recovery::Looking(base::MonotonicTime now) {
  const bool is_new = frame_ != nullptr && frame_->stamp >= since_;
  if (!is_new) {
    if (InState_s(now) > kMostLooking_s) {
      ++failures_;
      GiveUpServer("the camera gives no pictures", now);
    }
    return {};
  }
  const std::optional<localization::TrackedMotion> motion =
      tracker_.MotionAt(frame_->stamp);
  // The wheels of that moment come a little later.
  if (!motion.has_value()) return {};
  belief_.AddScan(motion->odom_from_base, tracker_.ScanInBase());
  ++questions_;
  Ask(*motion, now);
  BeginLook();
  Go(RecoveryState::kAsking, now);
  return {};
}

core::VelocityCommand Recovery::Asking(const RecoveryInput& input) {
  const std::optional<Answer> answer = AnswerBy(input.now);
  if (!answer.has_value()) {
    if (InState_s(input.now) > kPatience_s && MayTryClear()) {
      Note("recovery",
           "the server takes its time: tries what the laser says meanwhile");
      BeginSearch(input.now);
    }
    return {};
  }
  asks_ = false;
  if (!answer->ok()) {
    Failed(answer->status(), input.now);
  } else {
    Judge(**answer, input.now);
  }
  return {};
}

void Recovery::Failed(const absl::Status& status, base::MonotonicTime now) {
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

void Recovery::Judge(const core::RelocalizationAnswer& answer,
                     base::MonotonicTime now) {
  failures_ = 0;
  GatedFix fix = gate_.Check(answer, *asked_motion_, tracker_);
  answer_ = answer;
  answer_verdict_ = absl::StrCat(FixVerdictName(fix.verdict),
                                 fix.why.empty() ? "" : ": ", fix.why);
  Note("fix", answer_verdict_);
  const double yaw_rad = asked_motion_->odom_from_base.yaw_rad;
  if (IsRefused(fix.verdict)) {
    const bool is_near = fix.verdict == FixVerdict::kLowConfidence;
    belief_.AddAnswer(yaw_rad, is_near ? answer.confidence : 0.03);
    const bool is_elsewhere = fix.verdict == FixVerdict::kAgainstGravity ||
                              fix.verdict == FixVerdict::kNotOnGround ||
                              fix.verdict == FixVerdict::kAgainstScan;
    if (is_elsewhere && fix.is_server_sure && ++refused_ >= kMostRefused) {
      server_is_useless_ = true;
      GiveUpServer("what the server says does not fit here", now);
      return;
    }
    LookElsewhere(now);
    return;
  }
  refused_ = 0;
  belief_.AddAnswer(yaw_rad, fix.confidence);
  const auto agrees = std::ranges::find_if(
      waiting_, [&](const GatedFix& other) { return gate_.Agree(other, fix); });
  if (agrees != waiting_.end()) {
    Note("fix", "two views agree");
    // Doubtful views of the same thing err together; others add up.
    const double turned_rad = geometry::NormalizedAngle_rad(
        yaw_rad - agrees->motion.odom_from_base.yaw_rad);
    if (std::abs(turned_rad) >= kOtherView_rad) {
      fix.log_odds += agrees->log_odds;
    } else {
      fix.log_odds = std::max(fix.log_odds, agrees->log_odds);
    }
    fix.is_server_sure |= agrees->is_server_sure;
    Seed(fix, fix.is_server_sure || fix.log_odds >= kSureLogOdds, now);
    return;
  }
  const bool is_disputed =
      std::ranges::any_of(waiting_, &GatedFix::is_server_sure);
  if (cause_ != RecoveryCause::kCheck &&
      ((fix.verdict == FixVerdict::kSure && !is_disputed) ||
       IsClearPlace(fix))) {
    Seed(fix, false, now);
    return;
  }
  if (waiting_.size() >= kMostWaiting) waiting_.erase(waiting_.begin());
  waiting_.push_back(fix);
  LookElsewhere(now);
}

void Recovery::LookElsewhere(base::MonotonicTime now) {
  if (needs_help_) {
    Go(RecoveryState::kNeedHelp, now);
    return;
  }
  if (search_began_.has_value()) {
    Go(RecoveryState::kSearching, now);
    return;
  }
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  const bool has_time = SecondsBetween(began_, now) < options_.most_server_s;
  const auto clear = std::ranges::find_if(
      waiting_, [this](const GatedFix& fix) { return IsClearPlace(fix); });
  if (clear != waiting_.end() && cause_ != RecoveryCause::kCheck) {
    Note("fix", "scans fit where it was seen, and nowhere else");
    const GatedFix fix = *clear;
    waiting_.erase(clear);
    Seed(fix, false, now);
    return;
  }
  if (IsLasersTurn()) {
    Note("recovery", "tries what the laser says");
    BeginSearch(now);
    return;
  }
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

core::VelocityCommand Recovery::TurnTowards(double yaw_in_odom_rad) const {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return {};
  const double left_rad = geometry::NormalizedAngle_rad(
      yaw_in_odom_rad - motion->odom_from_base.yaw_rad);
  const double speed_radps =
      std::clamp(2 * std::abs(left_rad), 0.12, options_.turn_radps);
  return {.forward_mps = 0,
          .yaw_rate_radps = std::copysign(speed_radps, left_rad)};
}

core::VelocityCommand Recovery::Swing(const RecoveryInput& input,
                                      double speed_radps) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return {};
  // Also what the laser does not see may hold it.
  if (std::abs(motion->yaw_rate_radps) > kStands_radps) {
    swing_blocked_.reset();
    sides_blocked_ = 0;
  } else if (!swing_blocked_.has_value()) {
    swing_blocked_ = input.now;
  } else if (SecondsBetween(*swing_blocked_, input.now) > kSwingBlocked_s) {
    held_at_[swing_ > 0 ? 1 : 0] = motion->odom_from_base;
    swing_ = -swing_;
    swing_blocked_.reset();
    ++sides_blocked_;
  }
  // Once is enough.
  if (const std::optional<geometry::Rigid2>& held =
          held_at_[swing_ > 0 ? 1 : 0];
      held.has_value() &&
      geometry::Norm(held->translation - motion->odom_from_base.translation) <
          kSamePlace_m) {
    const double left_rad =
        swing_ * geometry::NormalizedAngle_rad(held->yaw_rad -
                                               motion->odom_from_base.yaw_rad);
    if (left_rad > 0 && left_rad < kKeepFrom_rad) swing_ = -swing_;
  }
  // Ahead it sees where it goes; behind it does not.
  if (sides_blocked_ >= 2 && input.free_ahead_m >= kRoom_m) {
    if (sides_blocked_ < kMostSidesBlocked) {
      return {.forward_mps = options_.move_mps, .yaw_rate_radps = 0};
    }
    sides_blocked_ = 0;
  }
  return {.forward_mps = 0, .yaw_rate_radps = swing_ * speed_radps};
}

core::VelocityCommand Recovery::Turning(const RecoveryInput& input) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return {};
  belief_.AddScan(motion->odom_from_base, tracker_.ScanInBase());
  if (IsLasersTurn()) {
    Note("recovery", "tries what the laser says");
    BeginSearch(input.now);
    return {};
  }
  const double left_rad = geometry::NormalizedAngle_rad(
      target_rad_ - motion->odom_from_base.yaw_rad);
  const double took_s = InState_s(input.now);
  if (std::abs(left_rad) < kTurned_rad || took_s > kMostTurning_s) {
    Go(RecoveryState::kStopping, input.now);
    return {};
  }
  if (took_s > kMostStuck_s &&
      std::abs(motion->yaw_rate_radps) < kStands_radps) {
    GiveUpServer("there is no room to turn", input.now);
    return {};
  }
  return TurnTowards(target_rad_);
}

void Recovery::Found(const std::string& how, base::MonotonicTime now) {
  const std::optional<localization::TrackedPose> pose = tracker_.Pose();
  Note("resume",
       absl::StrFormat("found after %.1f s and %d questions (%s): %.2f, %.2f "
                       "on level %d",
                       SecondsBetween(began_, now), questions_, how,
                       pose->pose.map_from_base.translation.x,
                       pose->pose.map_from_base.translation.y,
                       pose->pose.place.level));
  if (server_ != nullptr) server_->Cancel();
  asks_ = false;
  needs_help_ = false;
  look_ = Look::kNone;
  last_check_ = now;
  Go(RecoveryState::kFound, now);
}

void Recovery::RestoreBefore(base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!was_seeded_ || !before_.has_value() || !before_motion_.has_value() ||
      !motion.has_value()) {
    return;
  }
  was_seeded_ = false;
  localization::PoseCovariance2 covariance = before_->covariance;
  for (const size_t i : {size_t{0}, size_t{4}, size_t{8}}) {
    covariance[i] += 0.01;
  }
  tracker_
      .SetPose(CarriedOn(before_->pose, *before_motion_, *motion, *map_),
               covariance, now)
      .IgnoreError();
}

void Recovery::GiveUpServer(const std::string& why, base::MonotonicTime now) {
  if (server_ != nullptr) server_->Cancel();
  asks_ = false;
  if (needs_help_) {
    Go(RecoveryState::kNeedHelp, now);
    return;
  }
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

void Recovery::NeedHelp(base::MonotonicTime now) {
  if (server_ != nullptr) server_->Cancel();
  asks_ = false;
  needs_help_ = true;
  last_help_ = now;
  Note("help",
       "nobody found the robot's place: say where it is (initial pose), or "
       "drive it to where the map looks like nothing else");
  Go(RecoveryState::kNeedHelp, now);
}

}  // namespace treeline::behavior

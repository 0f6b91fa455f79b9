#include "nav_agent/behavior/relocalization_state_machine.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"

namespace treeline::behavior {
RelocalizationStateMachine::RelocalizationStateMachine(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, localization::RobotTracker& tracker,
    core::RelocalizationPort* server,
    const RelocalizationBehaviorOptions& options)
    : tools_(map, robot, tracker, options),
      checker_(std::move(map), robot, options.gate),
      question_(
          options.method == RelocalizationMethod::kServer ? server : nullptr,
          options.deadline_s),
      check_(options.check_interval_s) {}

RelocalizationState RelocalizationStateMachine::state() const {
  static_assert(std::is_same_v<
                std::variant_alternative_t<
                    static_cast<size_t>(RelocalizationState::kNeedHelp), State>,
                NeedHelpState>);
  return static_cast<RelocalizationState>(state_.index());
}

void RelocalizationStateMachine::AddFrame(const core::RgbdFrame& frame) {
  frame_ = std::make_shared<const core::RgbdFrame>(frame);
}

bool RelocalizationStateMachine::WantsPictures(base::MonotonicTime now) const {
  if (state() == RelocalizationState::kLooking) return true;
  if (!question_.has_server() || question_.is_open()) return false;
  if (state() == RelocalizationState::kNeedHelp) {
    return std::get<HelpWait>(phase_).IsTimeToAsk(
        tools_.options.help_interval_s, now);
  }
  return !IsActive() && check_.IsDue(now);
}

// ---- from outside ----

void RelocalizationStateMachine::Begin(RelocalizationCause cause,
                                       base::MonotonicTime now) {
  question_.Cancel();
  tools_.swing.ForgetHeld();
  tools_.unique.EndWholeMap();
  tools_.unique.ForgetPlace();
  episode_ = Episode();
  episode_.cause = cause;
  episode_.began = now;
  episode_.before = PlaceBefore(tools_.tracker);
  phase_ = CameraPhase();
  std::string text = RelocalizationCauseText(cause);
  if (cause == RelocalizationCause::kVerdict) {
    absl::StrAppend(
        &text, ": ",
        localization::LostReasonName(tools_.tracker.verdict().reason));
  }
  tools_.report.Note("lost", std::move(text));
  state_ = StoppingState(now);
}

void RelocalizationStateMachine::NotePoseWasSet(base::MonotonicTime now) {
  question_.Cancel();
  tools_.unique.EndWholeMap();
  if (IsActive()) tools_.report.Note("recovery", "it was told where it is");
  check_.Soon(now);
  phase_ = CameraPhase();
  state_ = IdleState();
}

RelocalizationBehavior::Output RelocalizationStateMachine::Step(
    const RelocalizationInput& input) {
  const base::MonotonicTime now = input.now;
  if (state() == RelocalizationState::kFound) state_ = IdleState();
  if (state() == RelocalizationState::kIdle) StepIdle(input);
  StepWholeMap(now);
  core::VelocityCommand wanted;
  switch (state()) {
    case RelocalizationState::kIdle:
    case RelocalizationState::kFound:
      break;
    case RelocalizationState::kNeedHelp:
      StepNeedHelp(now);
      break;
    case RelocalizationState::kStopping:
      StepStopping(now);
      break;
    case RelocalizationState::kLooking:
      StepLooking(now);
      break;
    case RelocalizationState::kAsking:
      StepAsking(now);
      break;
    case RelocalizationState::kTurning:
      wanted = StepTurning(input);
      break;
    case RelocalizationState::kConfirming:
      wanted = StepConfirming(input);
      break;
    case RelocalizationState::kSearching:
      wanted = StepSearching(input);
      break;
  }
  return {.state = state(), .wanted = wanted};
}

// ---- what each state does ----

void RelocalizationStateMachine::StepIdle(const RelocalizationInput& input) {
  if (tools_.tracker.verdict().state == localization::LostState::kLost) {
    Begin(RelocalizationCause::kVerdict, input.now);
    return;
  }
  if (check_.Step(input, frame_, checker_, question_, tools_)) {
    Begin(RelocalizationCause::kCheck, input.now);
  }
}

void RelocalizationStateMachine::StepStopping(base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion =
      tools_.tracker.Motion();
  if (!std::get<StoppingState>(state_).Step(motion, tools_.options.settle_s,
                                            now)) {
    return;
  }
  if (!episode_.belief.has_begun() && motion.has_value()) {
    episode_.belief.Begin(motion->odom_from_base);
  }
  if (MayAsk()) {
    state_ = LookingState(now);
  } else {
    GiveUpServer(question_.has_server() ? "the server was asked often enough"
                                        : "there is no server to ask",
                 now);
  }
}

void RelocalizationStateMachine::StepLooking(base::MonotonicTime now) {
  switch (std::get<LookingState>(state_).Step(frame_.get(), now)) {
    case LookingState::Outcome::kWaiting:
      return;
    case LookingState::Outcome::kNoPictures:
      ++episode_.failures;
      GiveUpServer("the camera gives no pictures", now);
      return;
    case LookingState::Outcome::kHasPicture:
      break;
  }
  const auto motion = tools_.tracker.MotionAt(frame_->stamp);
  // The wheels of that moment come a little later.
  if (!motion.has_value()) return;
  episode_.belief.AddScan(motion->odom_from_base, tools_.tracker.ScanInBase());
  ++episode_.questions;
  Ask(*motion, now);
  BeginWholeMap();
  state_ = AskingState(now);
}

void RelocalizationStateMachine::StepAsking(base::MonotonicTime now) {
  const std::optional<ServerQuestion::Answer> answer = question_.Take(now);
  if (answer.has_value()) {
    TakeAnswer(*answer, now);
  } else if (!std::get<AskingState>(state_).HasPatience(now) &&
             MayTryUniquePlace()) {
    tools_.report.Note(
        "recovery",
        "the server takes its time: tries what the laser says meanwhile");
    BeginSearch(now);
  }
}

core::VelocityCommand RelocalizationStateMachine::StepTurning(
    const RelocalizationInput& input) {
  const std::optional<localization::TrackedMotion> motion =
      tools_.tracker.Motion();
  if (!motion.has_value()) return {};
  episode_.belief.AddScan(motion->odom_from_base, tools_.tracker.ScanInBase());
  if (IsLasersTurn()) {
    tools_.report.Note("recovery", "tries what the laser says");
    BeginSearch(input.now);
    return {};
  }
  const TurningState::Result result = std::get<TurningState>(state_).Step(
      *motion, tools_.options.turn_radps, input.now);
  switch (result.outcome) {
    case TurningState::Outcome::kTurns:
      break;
    case TurningState::Outcome::kThere:
      state_ = StoppingState(input.now);
      break;
    case TurningState::Outcome::kNoRoom:
      GiveUpServer("there is no room to turn", input.now);
      break;
  }
  return result.wanted;
}

core::VelocityCommand RelocalizationStateMachine::StepConfirming(
    const RelocalizationInput& input) {
  const ConfirmingState::Result result =
      std::get<ConfirmingState>(state_).Step(input, tools_);
  switch (result.outcome) {
    case ConfirmingState::Outcome::kOpen:
      break;
    case ConfirmingState::Outcome::kFound:
      Found(result.why, input.now);
      break;
    case ConfirmingState::Outcome::kSecondView:
      LookAgain(result.why, input.now);
      break;
    case ConfirmingState::Outcome::kRefuted:
      NotConfirmed(result.why, input.now);
      break;
  }
  return result.wanted;
}

core::VelocityCommand RelocalizationStateMachine::StepSearching(
    const RelocalizationInput& input) {
  const std::optional<localization::TrackedMotion> motion =
      tools_.tracker.Motion();
  if (!motion.has_value()) return {};
  auto& search = std::get<LaserSearch>(phase_);
  search.AddTurn(*motion, tools_);
  if (question_.is_open()) {
    // Of a question that was open when the search began.
    const auto answer = question_.Take(input.now);
    if (answer.has_value()) TakeAnswer(*answer, input.now);
    if (state() != RelocalizationState::kSearching) return {};
  }
  const LaserSearch::Result result =
      search.Step(input, *motion,
                  {.may_be_asked = MayAsk(),
                   .is_asked = question_.is_open(),
                   .has_failed = episode_.failures > 0},
                  tools_);
  switch (result.outcome) {
    case LaserSearch::Outcome::kOpen:
      break;
    case LaserSearch::Outcome::kFound:
      Found("by laser alone, and scans fit nowhere else", input.now);
      break;
    case LaserSearch::Outcome::kTimeIsUp:
      NeedHelp(input.now);
      break;
    case LaserSearch::Outcome::kAsks:
      state_ = StoppingState(input.now);
      break;
    case LaserSearch::Outcome::kCamerasTurn:
      phase_ = CameraPhase();
      episode_.refused = 0;
      LookElsewhere(input.now);
      break;
  }
  return result.wanted;
}

void RelocalizationStateMachine::StepNeedHelp(base::MonotonicTime now) {
  if (!question_.has_server() || tools_.options.help_interval_s <= 0) return;
  if (question_.is_open()) {
    const auto answer = question_.Take(now);
    if (answer.has_value() && answer->ok()) Judge(**answer, now);
    return;
  }
  auto& wait = std::get<HelpWait>(phase_);
  if (!wait.IsTimeToAsk(tools_.options.help_interval_s, now) ||
      frame_ == nullptr || !IsFresh(*frame_, now)) {
    return;
  }
  const auto motion = tools_.tracker.MotionAt(frame_->stamp);
  if (!motion.has_value()) return;
  wait.NoteAsked(now);
  // Of the same view as the one before: two of them say no more than one.
  episode_.pending.Clear();
  episode_.is_server_useless = false;
  episode_.failures = 0;
  episode_.questions = 1;
  Ask(*motion, now);
}

// ---- the server's answers ----

bool RelocalizationStateMachine::MayAsk() const {
  return question_.has_server() && !episode_.is_server_useless &&
         episode_.questions < tools_.options.max_questions;
}

void RelocalizationStateMachine::Ask(const localization::TrackedMotion& motion,
                                     base::MonotonicTime now) {
  question_.Ask(frame_, motion, now);
}

void RelocalizationStateMachine::TakeAnswer(
    const ServerQuestion::Answer& answer, base::MonotonicTime now) {
  if (answer.ok()) {
    Judge(*answer, now);
  } else {
    Failed(answer.status(), now);
  }
}

void RelocalizationStateMachine::Failed(const absl::Status& status,
                                        base::MonotonicTime now) {
  ++episode_.failures;
  tools_.report.answer_verdict = std::string(status.ToString());
  tools_.report.Note("fix", absl::StrCat("the server did not answer: ",
                                         tools_.report.answer_verdict));
  if (absl::IsNotFound(status)) {
    episode_.is_server_useless = true;
    GiveUpServer("the server does not know this scene", now);
  } else if (episode_.failures >= tools_.options.max_failures ||
             !std::holds_alternative<CameraPhase>(phase_)) {
    GiveUpServer("the server does not answer", now);
  } else {
    // Once more, with a new picture.
    state_ = StoppingState(now);
  }
}

void RelocalizationStateMachine::Judge(const core::RelocalizationAnswer& answer,
                                       base::MonotonicTime now) {
  episode_.failures = 0;
  const GatedFix fix =
      checker_.Check(answer, question_.motion(), tools_.tracker);
  tools_.report.answer = answer;
  tools_.report.answer_verdict = FixText(fix);
  tools_.report.Note("fix", tools_.report.answer_verdict);
  const bool says_nothing =
      IsRefused(fix.verdict) && fix.verdict != FixVerdict::kLowConfidence;
  episode_.refused = IsRefused(fix.verdict) ? episode_.refused + 1 : 0;
  episode_.belief.AddAnswer(fix.motion.odom_from_base.yaw_rad,
                            says_nothing ? kRefusedPromise : fix.confidence);
  if (std::holds_alternative<LaserSearch>(phase_) &&
      LaserSearch::IsLikeliest(fix, tools_)) {
    tools_.report.Note("fix", "scans of all viewpoints say the same");
    Seed(fix, true, now);
    return;
  }
  // What the check found is not believed for one more view.
  const PendingFixes::Result result = episode_.pending.Add(
      fix, checker_.options(), episode_.cause != RelocalizationCause::kCheck,
      IsUniquePlace(fix));
  switch (result.decision) {
    case FixDecision::kLookOn:
      LookElsewhere(now);
      return;
    case FixDecision::kTake:
      Seed(result.fix, false, now);
      return;
    case FixDecision::kTakeAgreed:
      tools_.report.Note("fix", "two views agree");
      Seed(result.fix, AreViewsSure(result.fix), now);
      return;
    case FixDecision::kServerIsLost:
      episode_.is_server_useless = true;
      GiveUpServer("what the server says does not fit here", now);
      return;
  }
}

bool RelocalizationStateMachine::ReturnToPhase(base::MonotonicTime now) {
  if (std::holds_alternative<HelpWait>(phase_)) {
    state_ = NeedHelpState();
    return true;
  }
  if (!std::holds_alternative<LaserSearch>(phase_)) return false;
  if (state() != RelocalizationState::kSearching) {
    LaserSearch::Resume(tools_, now);
    state_ = SearchingState();
  }
  return true;
}

void RelocalizationStateMachine::LookElsewhere(base::MonotonicTime now) {
  if (ReturnToPhase(now) || SeedWaitingUniquePlace(now)) return;
  if (IsLasersTurn()) {
    tools_.report.Note("recovery", "tries what the laser says");
    BeginSearch(now);
    return;
  }
  if (IsServerFruitless()) {
    GiveUpServer("the server knows none of these views", now);
    return;
  }
  TurnToNextView(now);
}

bool RelocalizationStateMachine::IsServerFruitless() const {
  return episode_.cause != RelocalizationCause::kCheck &&
         episode_.pending.empty() && episode_.refused >= kQuestionsBeforeLaser;
}

bool RelocalizationStateMachine::SeedWaitingUniquePlace(
    base::MonotonicTime now) {
  if (episode_.cause == RelocalizationCause::kCheck) return false;
  const std::optional<GatedFix> fix = episode_.pending.TakeFirst(
      [this](const GatedFix& waiting) { return IsUniquePlace(waiting); });
  if (!fix.has_value()) return false;
  tools_.report.Note("fix", "scans fit where it was seen, and nowhere else");
  Seed(*fix, false, now);
  return true;
}

void RelocalizationStateMachine::TurnToNextView(base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion =
      tools_.tracker.Motion();
  const bool has_time =
      base::SecondsBetween(episode_.began, now) < tools_.options.max_server_s;
  if (!MayAsk() || !has_time || !motion.has_value()) {
    GiveUpServer("no answer of the server passed the checks", now);
    return;
  }
  const std::optional<double> next_rad =
      episode_.belief.Next(motion->odom_from_base.yaw_rad,
                           episode_.pending.LastYaw_rad(), kMinPromise);
  if (!next_rad.has_value()) {
    GiveUpServer("no direction is left that promises anything", now);
    return;
  }
  state_ = TurningState(*next_rad, now);
}

// ---- a place is taken, and does or does not hold ----

void RelocalizationStateMachine::Seed(const GatedFix& fix, bool was_seen_twice,
                                      base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion =
      tools_.tracker.Motion();
  if (!motion.has_value()) return;
  const core::LevelPose pose =
      PropagatedByOdometry(fix.pose, fix.motion, *motion, *tools_.map);
  const absl::Status told = tools_.tracker.SetPose(pose, fix.covariance, now);
  if (!told.ok()) {
    tools_.report.Note("fix", absl::StrCat("the fix could not be taken: ",
                                           std::string(told.ToString())));
    LookElsewhere(now);
    return;
  }
  episode_.before.NoteTold();
  tools_.report.Note("recovery", absl::StrCat("takes ", PoseText(pose),
                                              ", to see whether it holds"));
  state_ = ConfirmingState(fix, was_seen_twice, tools_, now);
}

void RelocalizationStateMachine::LookAgain(const std::string& why,
                                           base::MonotonicTime now) {
  if (!MayAsk()) {
    NotConfirmed(why + ", and the server cannot be asked again", now);
    return;
  }
  episode_.pending.Reset(std::get<ConfirmingState>(state_).seed());
  if (episode_.second_looks++ > 0 &&
      episode_.cause != RelocalizationCause::kCheck) {
    // What it sees here does not tell them apart.
    tools_.report.Note("recovery", why + ": goes on by laser");
    if (!ReturnToPhase(now)) BeginSearch(now);
    return;
  }
  tools_.report.Note("recovery", why + ": looks a second time");
  state_ = StoppingState(now);
}

void RelocalizationStateMachine::NotConfirmed(const std::string& why,
                                              base::MonotonicTime now) {
  tools_.report.Note("recovery", absl::StrCat("not there: ", why));
  tools_.report.answer_verdict =
      absl::StrCat("taken, and not confirmed: ", why);
  episode_.pending.Clear();
  const GatedFix& seed = std::get<ConfirmingState>(state_).seed();
  episode_.belief.AddAnswer(seed.motion.odom_from_base.yaw_rad,
                            kRefusedPromise);
  if (auto* search = std::get_if<LaserSearch>(&phase_)) {
    search->NoteRefuted(tools_);
  }
  LookElsewhere(now);
}

void RelocalizationStateMachine::Found(const std::string& how,
                                       base::MonotonicTime now) {
  const std::optional<localization::TrackedPose> pose = tools_.tracker.Pose();
  tools_.report.Note(
      "resume",
      absl::StrFormat(
          "found after %.1f s and %d questions (%s): %.2f, %.2f "
          "on level %d",
          base::SecondsBetween(episode_.began, now), episode_.questions, how,
          pose->pose.map_from_base.translation.x,
          pose->pose.map_from_base.translation.y, pose->pose.place.level));
  question_.Cancel();
  tools_.unique.EndWholeMap();
  check_.NoteDone(now);
  phase_ = CameraPhase();
  state_ = FoundState();
}

void RelocalizationStateMachine::GiveUpServer(const std::string& why,
                                              base::MonotonicTime now) {
  question_.Cancel();
  if (ReturnToPhase(now)) return;
  episode_.before.Restore(tools_.tracker, *tools_.map, now);
  if (episode_.cause == RelocalizationCause::kCheck) {
    // Nobody said so but one picture: it stays where it was.
    tools_.report.Note("check",
                       absl::StrCat("it stays where it thought it was: ", why));
    state_ = IdleState();
    return;
  }
  tools_.report.Note("recovery",
                     absl::StrCat(why, ": looks for its place by laser"));
  BeginSearch(now);
}

void RelocalizationStateMachine::NeedHelp(base::MonotonicTime now) {
  question_.Cancel();
  phase_ = HelpWait(now);
  tools_.report.Note(
      "help",
      "nobody found the robot's place: say where it is (initial pose), or "
      "drive it to where the map looks like nothing else");
  state_ = NeedHelpState();
}

// ---- what the laser alone says ----

void RelocalizationStateMachine::BeginSearch(base::MonotonicTime now) {
  auto& search = phase_.emplace<LaserSearch>(tools_, now);
  state_ = SearchingState();
  if (MayTryUniquePlace() && TryUniquePlace(now)) return;
  // Nobody was asked, so nobody has looked over the map yet.
  if (!tools_.unique.has_begun_whole_map()) BeginWholeMap();
  // Where the verdict is not, or no longer, that it is lost, what it knows gets
  // the chance of a full turn.
  if (!tools_.tracker.Pose().has_value() ||
      tools_.tracker.verdict().state == localization::LostState::kLost) {
    search.LookEverywhere(tools_, now);
  }
}

void RelocalizationStateMachine::BeginWholeMap() {
  if (tools_.options.method != RelocalizationMethod::kServer ||
      episode_.has_tried_unique_place) {
    return;
  }
  tools_.unique.BeginWholeMap();
}

void RelocalizationStateMachine::StepWholeMap(base::MonotonicTime now) {
  // Too late for a search that began without it?
  if (tools_.unique.StepWholeMap() &&
      state() == RelocalizationState::kSearching && MayTryUniquePlace()) {
    TryUniquePlace(now);
  }
}

bool RelocalizationStateMachine::MayTryUniquePlace() const {
  return tools_.unique.place().has_value() &&
         !episode_.has_tried_unique_place &&
         !std::holds_alternative<HelpWait>(phase_) &&
         episode_.cause != RelocalizationCause::kCheck;
}

bool RelocalizationStateMachine::IsLasersTurn() const {
  return MayTryUniquePlace() && (episode_.pending.empty() ||
                                 episode_.questions >= kQuestionsBeforeLaser);
}

bool RelocalizationStateMachine::TryUniquePlace(base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion =
      tools_.tracker.Motion();
  if (!motion.has_value()) return false;
  episode_.has_tried_unique_place = true;
  if (!std::get<LaserSearch>(phase_).TryUniquePlace(*tools_.unique.place(),
                                                    *motion, tools_, now)) {
    return false;
  }
  episode_.before.NoteTold();
  return true;
}

bool RelocalizationStateMachine::IsUniquePlace(const GatedFix& fix) const {
  const std::optional<UniquePlace>& place = tools_.unique.place();
  if (!place.has_value()) return false;
  const core::LevelPose expected =
      PropagatedByOdometry(place->pose, place->motion, fix.motion, *tools_.map);
  return AreWithin(expected, fix.pose, checker_.options().pair_m,
                   checker_.options().pair_rad);
}

}  // namespace treeline::behavior

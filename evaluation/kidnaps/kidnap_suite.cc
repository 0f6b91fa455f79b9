#include "evaluation/kidnaps/kidnap_suite.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "evaluation/suites/suite_route.h"
#include "nav_agent/app/relocalization/server_relocalization.h"

namespace treeline::kidnaps {
namespace {

constexpr int kTries = 2000;
// What is nearer than both of these is no kidnap.
constexpr double kAway_m = 1.0;
constexpr double kTurned_deg = 45;
constexpr double kMinWay_m = 6;
// A kidnap comes when so much of the way is driven.
constexpr double kFromShare = 0.1;
constexpr double kToShare = 0.6;
constexpr double kMaxBefore_s = 120;
// The judge looks every fourth step.
constexpr int kLookEvery = 4;
constexpr double kArrivalPatience_s = 40;
// Obstacles do not need 640 x 480 pixels, which take 0.1 s to render.
constexpr double kDepthCameraScale = 0.25;
constexpr double kArrivalPatience_spm = 8;

bool IsLooking(behavior::NavigatorMode mode) {
  return mode == behavior::NavigatorMode::kLost ||
         mode == behavior::NavigatorMode::kRelocalizing ||
         mode == behavior::NavigatorMode::kNeedHelp;
}

bool GoesOn(behavior::NavigatorMode mode) {
  return mode == behavior::NavigatorMode::kDriving ||
         mode == behavior::NavigatorMode::kPlanning ||
         mode == behavior::NavigatorMode::kRecovering;
}

double TurnBetween_deg(double a_rad, double b_rad) {
  return std::abs(geometry::NormalizedAngle_rad(a_rad - b_rad)) * 180 /
         std::numbers::pi;
}

// Another place than `than`, from where there is a way to the goal.
absl::StatusOr<simulator::RobotPlacement> ElsewhereThan(
    const suites::SuitePlace& place, const simulator::RobotPlacement& than,
    const simulator::RobotPlacement& goal, base::Random& random) {
  for (int i = 0; i < kTries; ++i) {
    const simulator::RobotPlacement there = place.AnyPlace(random);
    const double away_m = Norm(there.position - than.position);
    if (away_m < kAway_m &&
        TurnBetween_deg(there.yaw_rad, than.yaw_rad) < kTurned_deg &&
        std::abs(there.height_m - than.height_m) <
            suites::kRightWithinHeight_m) {
      continue;
    }
    // Not beside the goal: there would be nothing to drive.
    if (Norm(there.position - goal.position) < 2) continue;
    if (!place.InMap(there).ok()) continue;
    return there;
  }
  return absl::FailedPreconditionError(
      "the world has no room to be carried away to");
}

// Counts what it is asked.
class CountingPort final : public core::RelocalizationPort {
 public:
  explicit CountingPort(std::unique_ptr<core::RelocalizationPort> port)
      : port_(std::move(port)) {}

  void Ask(const core::RgbdFrame& frame, double timeout_s) override {
    ++questions_;
    port_->Ask(frame, timeout_s);
  }
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> TakeAnswer()
      override {
    return port_->TakeAnswer();
  }
  bool IsAsking() const override { return port_->IsAsking(); }
  void Cancel() override { port_->Cancel(); }
  int questions() const { return questions_; }

 private:
  std::unique_ptr<core::RelocalizationPort> port_;
  int questions_ = 0;
};

// One kidnapped robot.
class Kidnapping {
 public:
  Kidnapping(const suites::SuitePlace& place, const KidnapOptions& options,
             const std::stop_token& stop)
      : place_(&place),
        options_(options),
        stop_(stop),
        random_(options.seed, 300) {}

  absl::StatusOr<KidnapRun> Run() {
    run_.is_warm = options_.seed % 2 == 1;
    base::Random random(options_.seed, suites::kRouteStream);
    TL_ASSIGN_OR_RETURN(
        route_, suites::DrawRoute(*place_, options_.seed, kMinWay_m, random));
    run_.goal = route_.goal;
    TL_RETURN_IF_ERROR(run_.is_warm ? BeginWarm() : BeginCold());
    KidnapJudge judge(run_.kidnap_s);
    TL_RETURN_IF_ERROR(Watch(judge));
    Summarize(judge);
    return std::move(run_);
  }

 private:
  absl::Status MakeRobot() {
    suites::SuiteRobotOptions robot;
    robot.start = route_.start;
    robot.seed = options_.seed;
    robot.robot = options_.robot;
    robot.camera_hz = options_.camera_hz;
    robot.has_rear_laser = options_.has_rear_laser;
    robot.navigator = options_.navigator;
    if (options_.sees_depth) {
      robot.camera_scale = kDepthCameraScale;
      robot.camera_is_lit = false;
    } else {
      // Pictures are rendered for questions and checks alone.
      robot.navigator.depth_hz = 0;
    }
    if (options_.server != nullptr) {
      robot.make_server = [this](const base::Clock& clock) {
        // What is sent and asked for can be said: no errors.
        auto port = std::make_unique<CountingPort>(
            *relocalization::MakeSynchronousRelocalization(
                options_.server,
                {.scene = options_.scene, .seed = options_.seed}, clock,
                {.latency_s = options_.latency_s,
                 .real_timeout_s = options_.real_timeout_s}));
        port_ = port.get();
        return port;
      };
    }
    TL_ASSIGN_OR_RETURN(
        robot_, suites::SuiteRobot::Create(*place_, place_->world(), robot));
    return absl::OkStatus();
  }

  absl::Status Begin(const simulator::RobotPlacement& told) {
    TL_RETURN_IF_ERROR(MakeRobot());
    TL_ASSIGN_OR_RETURN(const core::LevelPose pose, place_->InMap(told));
    TL_ASSIGN_OR_RETURN(const core::LevelPose goal, place_->InMap(run_.goal));
    TL_RETURN_IF_ERROR(robot_->Tell(pose));
    return robot_->navigator().SetGoal({.poses = {goal}}).status();
  }

  absl::Status Measure(const simulator::RobotPlacement& estimate) {
    run_.kidnap_s = robot_->now_s();
    run_.away_m = Norm(estimate.position - run_.real.position);
    run_.turned_deg = TurnBetween_deg(estimate.yaw_rad, run_.real.yaw_rad);
    return absl::OkStatus();
  }

  absl::Status BeginWarm() {
    TL_RETURN_IF_ERROR(Begin(route_.start));
    const double share = random_.NextUniform(kFromShare, kToShare);
    while (robot_->record().final_state.distance_m < share * route_.way_m &&
           robot_->now_s() < kMaxBefore_s) {
      if (stop_.stop_requested()) return absl::CancelledError("interrupted");
      robot_->Step();
    }
    const simulator::RobotPlacement before =
        suites::PlacementOf(robot_->simulator().state().world_from_base);
    for (int i = 0;; ++i) {
      TL_ASSIGN_OR_RETURN(run_.real,
                          ElsewhereThan(*place_, before, run_.goal, random_));
      const absl::Status kidnapped = robot_->simulator().Kidnap(run_.real);
      if (kidnapped.ok()) break;
      if (i == kTries) return kidnapped;
    }
    return Measure(before);
  }

  absl::Status BeginCold() {
    run_.real = route_.start;
    TL_ASSIGN_OR_RETURN(
        const simulator::RobotPlacement told,
        ElsewhereThan(*place_, route_.start, run_.goal, random_));
    TL_RETURN_IF_ERROR(Begin(told));
    return Measure(told);
  }

  absl::Status Watch(KidnapJudge& judge) {
    double until_s = run_.kidnap_s + options_.patience_s;
    bool was_back = false;
    behavior::NavigatorMode last = robot_->navigator().mode();
    for (int i = 0; robot_->now_s() < until_s; ++i) {
      if (stop_.stop_requested()) return absl::CancelledError("interrupted");
      robot_->Step();
      const behavior::NavigatorMode mode = robot_->navigator().mode();
      const std::optional<behavior::GoalStatus> goal =
          robot_->navigator().goal();
      run_.arrived =
          goal.has_value() && goal->state == behavior::GoalState::kSucceeded;
      if (i % kLookEvery == 0 || mode != last) {
        judge.Observe(robot_->now_s(), mode, run_.arrived,
                      robot_->EstimateError());
      }
      last = mode;
      if (robot_->record().final_state.is_fallen || judge.NeedsHelp()) break;
      if (judge.IsBack() && !was_back) {
        was_back = true;
        if (!options_.drives_on) break;
        until_s = robot_->now_s() + kArrivalPatience_s +
                  kArrivalPatience_spm * 2 * route_.way_m;
      }
      if (goal.has_value() &&
          (goal->state == behavior::GoalState::kFailed ||
           goal->state == behavior::GoalState::kCancelled)) {
        break;
      }
      if (run_.arrived && judge.IsBack()) break;
      if (run_.arrived) until_s = std::min(until_s, robot_->now_s() + 3);
    }
    return absl::OkStatus();
  }

  void Summarize(const KidnapJudge& judge) {
    suites::Summarize(*robot_, run_.goal, run_);
    const std::optional<behavior::GoalStatus> status =
        robot_->navigator().goal();
    if (status.has_value() && status->state == behavior::GoalState::kFailed) {
      run_.cause = status->cause;
      run_.why = status->why;
    }
    judge.Judge(run_);
    if (port_ != nullptr) run_.questions = port_->questions();
    if (run_.record.final_state.is_fallen) run_.outcome = KidnapOutcome::kFell;
    if (run_.arrived) {
      const absl::StatusOr<core::LevelPose> goal = place_->InMap(run_.goal);
      run_.arrived =
          goal.ok() &&
          place_->ErrorOf(*goal, run_.record.final_state.world_from_base)
              .IsRight();
    }
  }

  const suites::SuitePlace* place_;
  KidnapOptions options_;
  std::stop_token stop_;
  base::Random random_;
  KidnapRun run_;
  suites::Route route_;
  std::unique_ptr<suites::SuiteRobot> robot_;
  // The robot's; null: none.
  CountingPort* port_ = nullptr;
};

}  // namespace

const char* KidnapOutcomeName(KidnapOutcome outcome) {
  switch (outcome) {
    case KidnapOutcome::kBack:
      return "back";
    case KidnapOutcome::kLate:
      return "late";
    case KidnapOutcome::kWrong:
      return "wrong";
    case KidnapOutcome::kNeedHelp:
      return "need_help";
    case KidnapOutcome::kUnnoticed:
      return "unnoticed";
    case KidnapOutcome::kSearching:
      return "searching";
    case KidnapOutcome::kFell:
      return "fell";
  }
  return "unknown";
}

void KidnapJudge::Observe(double now_s, behavior::NavigatorMode mode,
                          bool has_arrived,
                          const std::optional<suites::PoseMiss>& error) {
  const bool is_right = error.has_value() && error->IsRight();
  if (IsLooking(mode)) {
    if (!noticed_s_.has_value()) noticed_s_ = now_s;
    looked_ = true;
    needs_help_ = mode == behavior::NavigatorMode::kNeedHelp;
    right_since_s_.reset();
    return;
  }
  const bool goes_on = GoesOn(mode) || has_arrived;
  if (!goes_on) return;
  if (looked_) {
    looked_ = false;
    ++resumptions_;
    if (!is_right) ++wrong_resumptions_;
    if (resumptions_ == 1 || !is_right) {
      resumed_error_ = error.value_or(suites::PoseMiss{.distance_m = -1});
    }
  }
  if (!is_right) {
    right_since_s_.reset();
    return;
  }
  if (!right_since_s_.has_value()) {
    right_since_s_ = now_s;
    right_error_ = *error;
  }
  if (!back_s_.has_value() && now_s - *right_since_s_ >= kSure_s) {
    back_s_ = right_since_s_;
  }
}

void KidnapJudge::Judge(KidnapRun& run) const {
  run.noticed_after_s = noticed_s_.has_value() ? *noticed_s_ - kidnap_s_ : -1;
  run.back_after_s = back_s_.has_value() ? *back_s_ - kidnap_s_ : -1;
  run.resumptions = resumptions_;
  run.wrong_resumptions = wrong_resumptions_;
  run.error_at_resumption = resumptions_ > 0 ? resumed_error_ : right_error_;
  if (wrong_resumptions_ > 0) {
    run.outcome = KidnapOutcome::kWrong;
  } else if (back_s_.has_value()) {
    run.outcome = run.back_after_s <= kBackWithin_s ? KidnapOutcome::kBack
                                                    : KidnapOutcome::kLate;
  } else if (needs_help_) {
    run.outcome = KidnapOutcome::kNeedHelp;
  } else {
    run.outcome = noticed_s_.has_value() ? KidnapOutcome::kSearching
                                         : KidnapOutcome::kUnnoticed;
  }
}

absl::StatusOr<KidnapRun> RunKidnap(const suites::SuitePlace& place,
                                    const KidnapOptions& options,
                                    const std::stop_token& stop) {
  return Kidnapping(place, options, stop).Run();
}

}  // namespace treeline::kidnaps

#include "nav_agent/docking/dock_pilot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"
#include "nav_agent/docking/dock_drive.h"
#include "nav_agent/docking/parameters.h"
#include "nav_agent/docking/pilot_terms.h"

namespace treeline::docking {
namespace {

using behavior::GoalState;
using behavior::NavigatorMode;

// Between looks at where a robot stands that nobody asks anything of (s).
constexpr double kLookEvery_s = 0.5;
// It got on if it came so much further, or turned (m, rad).
constexpr double kGotOn_m = 0.01;
constexpr double kGotOn_rad = 0.02;
// As near as it drives by itself, and so long it stands then (m, s).
constexpr double kNear_m = kTolerance_m / 4;
constexpr double kStands_s = 1;
// A battery that does not charge any more (of a full one).
constexpr double kFull = 0.99;
// So far the estimate of a robot that charges may move (m, rad).
constexpr double kDrifted_m = 0.08;
constexpr double kDrifted_rad = 0.1;
// What a view of its dock tells a robot: 2 cm, 1 degree (m^2, rad^2).
constexpr localization::PoseCovariance2 kWokenCovariance = {
    4e-4, 0, 0, 0, 4e-4, 0, 0, 0, 3e-4};

}  // namespace

// ---- what it is told ----

absl::Status DockPilot::Check(behavior::Navigator& navigator,
                              const Dock& dock) {
  return navigator.Steer({.wanted = {},
                          .docked = OnLevel(dock, dock.map_from_docked),
                          .is_backward = dock.is_backward,
                          .what = "looks for its dock"});
}

absl::StatusOr<uint64_t> DockPilot::Begin(behavior::Navigator& navigator,
                                          const Dock& dock) {
  TL_RETURN_IF_ERROR(Check(navigator, dock));
  if (IsUnderWay()) {
    End(DockingOutcome::kCancelled, "another docking took its place");
  }
  dock_ = dock;
  const uint64_t id = status_.id + 1;
  const std::optional<core::LevelPose> robot = PoseOf(navigator);
  if (robot.has_value() && IsAt(dock, *robot) &&
      charging_ == core::Charging::kYes) {
    status_ = {.id = id, .outcome = DockingOutcome::kUnderWay};
    Arrive(navigator, OffsetFrom(dock, robot->map_from_base), "it charges");
    return id;
  }
  // A goal of its own, or of a route, ends with that.
  TL_RETURN_IF_ERROR(GoToStaging(navigator));
  status_ = {.id = id,
             .outcome = DockingOutcome::kUnderWay,
             .state = DockingState::kToStaging,
             .dock = dock.name};
  events_.Add("dock", absl::StrCat("drives to dock '", dock.name, "'"));
  return id;
}

absl::Status DockPilot::DriveOut(behavior::Navigator& navigator) {
  if (const auto stop = navigator.Snapshot().stop) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the robot is stopped (", stop->why, "); release it first"));
  }
  const std::optional<core::LevelPose> robot = PoseOf(navigator);
  if (!robot.has_value() || IsUnderWay()) {
    return absl::FailedPreconditionError(
        IsUnderWay() ? "the robot is on its way to a dock; cancel that first"
                     : "the robot does not know where it is");
  }
  for (const Dock& dock : *docks_) {
    if (!IsInside(dock, *robot, robot_)) continue;
    BeginOut(dock);
    is_out_asked_for_ = true;
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError("the robot is in no dock");
}

absl::Status DockPilot::Cancel(behavior::Navigator& navigator) {
  if (IsUnderWay()) {
    // NOT_FOUND: it is over.
    (void)navigator.CancelGoal(goal_id_);
    End(DockingOutcome::kCancelled, "somebody cancelled it");
    return absl::OkStatus();
  }
  if (status_.state == DockingState::kDrivingOut && is_out_asked_for_) {
    EndOut("somebody cancelled that");
    return absl::OkStatus();
  }
  return absl::NotFoundError("there is no docking to cancel");
}

// ---- one step ----

void DockPilot::Step(behavior::Navigator& navigator, base::MonotonicTime now,
                     const std::optional<core::Battery>& battery) {
  now_ = now;
  events_.SetTime(now);
  charging_ =
      battery.has_value() ? battery->charging : core::Charging::kUnknown;
  is_full_ = battery.has_value() && battery->charge.value_or(0) >= kFull;
  if (is_halted_) return;
  FollowDocks(navigator);
  TellThings(navigator);
  WakeUp(navigator);
  LookAtGoal(navigator);
  switch (status_.state) {
    case DockingState::kAway:
    case DockingState::kDocked:
      LookWhereItIs(navigator);
      LearnView(navigator);
      break;
    case DockingState::kToStaging:
      StepToStaging(navigator);
      break;
    case DockingState::kDrivingIn:
    case DockingState::kTouching:
      if (MaySteer(navigator)) StepIn(navigator);
      break;
    case DockingState::kBackingOut:
    case DockingState::kDrivingOut:
      if (MaySteer(navigator)) StepOut(navigator);
      break;
  }
}

void DockPilot::FollowDocks(behavior::Navigator& navigator) {
  if (!IsUnderWay()) return;
  const auto found = std::ranges::find(*docks_, dock_.name, &Dock::name);
  if (found == docks_->end()) {
    (void)navigator.CancelGoal(goal_id_);
    End(DockingOutcome::kFailed, "the dock was removed");
    return;
  }
  const Dock before = std::exchange(dock_, *found);
  if (IsSamePlace(before, dock_)) return;
  events_.Add("dock", absl::StrCat("dock '", dock_.name, "' was moved"));
  const absl::Status sent = GoToStaging(navigator);
  if (!sent.ok()) End(DockingOutcome::kFailed, std::string(sent.message()));
}

absl::Status DockPilot::GoToStaging(behavior::Navigator& navigator) {
  const core::LevelPose staging = OnLevel(dock_, StagingPose(dock_));
  TL_ASSIGN_OR_RETURN(goal_id_, navigator.SetGoal({.poses = {staging}}));
  target_ = staging;
  Enter(DockingState::kToStaging);
  return absl::OkStatus();
}

void DockPilot::StepToStaging(behavior::Navigator& navigator) {
  const std::optional<behavior::GoalStatus> goal = navigator.goal();
  if (!goal.has_value() || goal->id != goal_id_) {
    End(DockingOutcome::kCancelled, "another goal took its place");
  } else if (goal->state == GoalState::kSucceeded) {
    charged_before_ = charging_ == core::Charging::kYes;
    is_move_told_ = false;
    Enter(DockingState::kDrivingIn);
  } else if (goal->state == GoalState::kCancelled) {
    End(DockingOutcome::kCancelled, goal->why);
  } else if (goal->state == GoalState::kFailed) {
    End(DockingOutcome::kFailed,
        absl::StrCat("the pose before it cannot be reached (",
                     core::NavigationCauseName(goal->cause), "): ", goal->why));
  }
}

bool DockPilot::MaySteer(behavior::Navigator& navigator) {
  const NavigatorMode mode = navigator.mode();
  const bool is_out = status_.state == DockingState::kDrivingOut;
  const std::optional<behavior::GoalStatus> goal = navigator.goal();
  if (mode == NavigatorMode::kStopped || mode == NavigatorMode::kManual) {
    const char* why = mode == NavigatorMode::kStopped
                          ? "the robot was stopped"
                          : "the robot was driven by hand";
    if (IsUnderWay()) {
      End(DockingOutcome::kCancelled, why);
    } else {
      EndOut(why);
    }
    return false;
  }
  if (IsUnderWay() && (!goal.has_value() || goal->id != goal_id_)) {
    End(DockingOutcome::kCancelled, "another goal took its place");
    return false;
  }
  if (is_out && !IsUnderWay() && !is_out_asked_for_ && !IsActive(goal)) {
    EndOut("there is no goal any more");
    return false;
  }
  if (IsLost(mode) || !PoseOf(navigator).has_value()) {
    if (!IsUnderWay()) {
      EndOut("it does not know where it is");
      return false;
    }
    // It waits for its place, and comes back.
    const absl::Status sent = GoToStaging(navigator);
    if (!sent.ok()) End(DockingOutcome::kFailed, std::string(sent.message()));
    return false;
  }
  // Paused, or a device is lost: nothing is to be expected of it.
  if (mode != NavigatorMode::kDriving) got_on_.reset();
  return true;
}

void DockPilot::StepIn(behavior::Navigator& navigator) {
  const core::LevelPose robot = *PoseOf(navigator);
  if (robot.place.level != dock_.level) {
    FailTry("it is on another level");
    return;
  }
  LookForDock(navigator);
  const DockOffset off = OffsetFrom(seen_, robot.map_from_base);
  if (!charged_before_ && charging_ == core::Charging::kYes &&
      IsAt(seen_, robot)) {
    StepCharging(navigator, off);
  } else if (status_.state == DockingState::kTouching) {
    StepTouching(navigator, off);
  } else {
    StepInAt(navigator, off);
  }
}

void DockPilot::StepCharging(behavior::Navigator& navigator,
                             const DockOffset& off) {
  if (!contact_along_m_.has_value()) {
    contact_along_m_ = off.along_m;
    got_on_.reset();
  }
  NoteProgress(off.along_m, off.turned_rad);
  if (off.along_m >= -kTolerance_m || Stood_s() > kStands_s ||
      off.along_m >= *contact_along_m_ + kPress_m) {
    Arrive(navigator, off, "it charges");
    return;
  }
  Steer(navigator, seen_, DriveIn(seen_, off, robot_),
        absl::StrCat("drives into dock '", dock_.name, "'"));
}

void DockPilot::StepInAt(behavior::Navigator& navigator,
                         const DockOffset& off) {
  NoteProgress(off.along_m, off.turned_rad);
  const std::string what = absl::StrCat("drives into dock '", dock_.name, "'");
  const bool is_there = off.along_m >= -kNear_m ||
                        (off.along_m >= -kTolerance_m && Stood_s() > kStands_s);
  const bool is_turned = std::abs(off.turned_rad) > kTolerance_rad;
  // It turns at both ends; on the way the line straightens it.
  if (is_turned && (is_there || !is_straight_)) {
    if (Stood_s() > kPatience_s) {
      FailTry("it cannot turn there");
      return;
    }
    Steer(navigator, seen_, TurnStraight(off), what);
    return;
  }
  is_straight_ = true;
  if (!is_there) {
    if (Stood_s() > kPatience_s) {
      FailTry(absl::StrFormat("something stands in the way, %.2f m before it",
                              -off.along_m));
      return;
    }
    Steer(navigator, seen_, DriveIn(seen_, off, robot_), what);
    return;
  }
  if (charging_ == core::Charging::kNo && !is_full_) {
    Enter(DockingState::kTouching);
    Steer(navigator, seen_, PressOn(seen_), what);
  } else if (std::abs(off.aside_m) > kTolerance_m) {
    FailTry(absl::StrCat("it came in ", OffText(off)));
  } else {
    Arrive(navigator, off, "it stands there");
  }
}

void DockPilot::StepTouching(behavior::Navigator& navigator,
                             const DockOffset& off) {
  if (!got_on_.has_value()) got_on_ = now_;
  if (Stood_s() > kContact_s) {
    FailTry(
        absl::StrCat("the battery does not charge: it stood ", OffText(off)));
    return;
  }
  Steer(navigator, seen_,
        off.along_m < kPress_m ? PressOn(seen_) : core::VelocityCommand{},
        absl::StrCat("looks for the contact of dock '", dock_.name, "'"));
}

void DockPilot::FailTry(const std::string& why) {
  ++status_.failed_tries;
  failed_why_ = why;
  events_.Add("dock",
              absl::StrCat("try ", status_.failed_tries, " of ", kTries.value,
                           " at dock '", dock_.name, "': ", why));
  Enter(DockingState::kBackingOut);
}

void DockPilot::StepOut(behavior::Navigator& navigator) {
  const bool is_leaving = status_.state == DockingState::kDrivingOut;
  const Dock dock =
      sight_.Look(is_leaving ? out_of_ : dock_, navigator.Snapshot(), now_);
  const DockOffset off = OffsetFrom(dock, PoseOf(navigator)->map_from_base);
  NoteProgress(-off.along_m, 0);
  const bool is_out = -off.along_m >= dock.staging_m - kAtDock_m;
  const bool is_held = Stood_s() > kPatience_s;
  if (!is_out && !is_held) {
    Steer(navigator, dock, docking::DriveOut(dock, off, robot_),
          absl::StrCat("drives out of dock '", dock.name, "'"));
    return;
  }
  if (is_leaving) {
    Release(navigator);
    EndOut(is_out ? "" : "something holds it there");
  } else if (status_.failed_tries >= kTries || is_held) {
    End(DockingOutcome::kFailed,
        absl::StrCat(failed_why_, is_held ? "; and it cannot back out" : ""));
  } else {
    const absl::Status sent = GoToStaging(navigator);
    if (!sent.ok()) End(DockingOutcome::kFailed, std::string(sent.message()));
  }
}

void DockPilot::Arrive(behavior::Navigator& navigator, const DockOffset& off,
                       const std::string& by) {
  // The goal of its staging pose may not be over: it was there already.
  (void)navigator.CancelGoal(goal_id_);
  End(DockingOutcome::kSucceeded,
      absl::StrCat(by, ", ", OffText(off),
                   sight_.seen().has_value() ? ", as it sees" : ""));
  status_.state = DockingState::kDocked;
  status_.dock = dock_.name;
}

void DockPilot::End(DockingOutcome outcome, const std::string& why) {
  status_.outcome = outcome;
  status_.why = why;
  status_.state = DockingState::kAway;
  status_.dock.clear();
  goal_id_ = 0;
  looked_.reset();
  const char* what = outcome == DockingOutcome::kSucceeded ? "docked in '"
                     : outcome == DockingOutcome::kCancelled
                         ? "gives up dock '"
                         : "fails at dock '";
  events_.Add("dock", absl::StrCat(what, dock_.name, "': ", why));
}

// ---- out of a dock ----

// A goal begins in a dock, or begins again there.
void DockPilot::LookAtGoal(behavior::Navigator& navigator) {
  const std::optional<behavior::GoalStatus> goal = navigator.goal();
  if (docks_->empty() || !IsActive(goal) || IsSteered() ||
      goal->id == released_goal_) {
    return;
  }
  const NavigatorMode mode = navigator.mode();
  const bool begins =
      goal->id != seen_goal_ || mode == NavigatorMode::kPlanning;
  if (!begins || mode == NavigatorMode::kStopped ||
      mode == NavigatorMode::kManual || IsLost(mode)) {
    return;
  }
  const std::optional<core::LevelPose> robot = PoseOf(navigator);
  if (!robot.has_value()) return;
  seen_goal_ = goal->id;
  for (const Dock& dock : *docks_) {
    if (!IsInside(dock, *robot, robot_)) continue;
    BeginOut(dock);
    return;
  }
}

void DockPilot::BeginOut(const Dock& dock) {
  out_of_ = dock;
  is_out_asked_for_ = false;
  status_.dock = dock.name;
  events_.Add("dock", absl::StrCat("drives out of dock '", dock.name, "'"));
  Enter(DockingState::kDrivingOut);
}

void DockPilot::EndOut(const std::string& why_not) {
  events_.Add("dock", why_not.empty()
                          ? absl::StrCat("is out of dock '", out_of_.name, "'")
                          : absl::StrCat("is not out of dock '", out_of_.name,
                                         "': ", why_not));
  is_out_asked_for_ = false;
  if (IsUnderWay()) {
    Enter(DockingState::kToStaging);
    status_.dock = dock_.name;
    return;
  }
  status_.state = DockingState::kAway;
  status_.dock.clear();
  looked_.reset();
}

// ---- what it sees ----

void DockPilot::TellThings(behavior::Navigator& navigator) {
  if (told_ == docks_) return;
  told_ = docks_;
  navigator.SetKnownThings(ThingsAt(*docks_));
}

void DockPilot::WakeUp(behavior::Navigator& navigator) {
  if (charging_ != core::Charging::kYes || docks_->empty()) {
    charges_at_.reset();
    carried_from_.clear();
    return;
  }
  const behavior::NavigatorSnapshot shot = navigator.Snapshot();
  const bool is_lost = IsLost(navigator.mode()) || !shot.pose.has_value();
  if (shot.command != core::VelocityCommand{}) charges_at_.reset();
  if (!is_lost && !charges_at_.has_value()) {
    if (IsDocked() && IsStill(shot) && status_.dock != carried_from_) {
      charges_at_ = shot.pose->pose;
      charges_in_ = status_.dock;
    }
    return;
  }
  if (woke_.has_value() && base::SecondsBetween(*woke_, now_) < kLookEvery_s) {
    return;
  }
  woke_ = now_;
  if (charges_at_.has_value()) {
    HoldWhereItCharges(navigator, is_lost, shot);
    return;
  }
  const std::optional<core::LevelPose> found = DockSight::FindIn(*docks_, shot);
  if (!found.has_value() || !navigator.SetPose(*found, kWokenCovariance).ok()) {
    return;
  }
  looked_.reset();
  carried_from_.clear();
  events_.Add("dock", "charges and sees its dock: it knows where it is");
}

// Where a dock hides most of the room, what is left of it moves the estimate.
void DockPilot::HoldWhereItCharges(behavior::Navigator& navigator, bool is_lost,
                                   const behavior::NavigatorSnapshot& shot) {
  if (WasCarried(shot)) {
    charges_at_.reset();
    carried_from_ = charges_in_;
    events_.Add("dock", absl::StrCat("charges, but does not see what is seen "
                                     "from dock '",
                                     charges_in_, "': it has been carried"));
    return;
  }
  if (!is_lost) {
    const geometry::Rigid2 off =
        charges_at_->map_from_base.Inverse() * shot.pose->pose.map_from_base;
    if (geometry::Norm(off.translation) <= kDrifted_m &&
        std::abs(off.yaw_rad) <= kDrifted_rad) {
      return;
    }
  }
  if (!navigator.SetPose(*charges_at_, kWokenCovariance).ok()) return;
  looked_.reset();
  if (is_lost) {
    events_.Add("dock", "it charges where it did: it has not been carried");
  }
}

bool DockPilot::WasCarried(const behavior::NavigatorSnapshot& shot) const {
  const auto dock = std::ranges::find(*docks_, charges_in_, &Dock::name);
  return dock != docks_->end() && IsElsewhere(*dock, shot.scan_in_base, robot_);
}

void DockPilot::LearnView(const behavior::Navigator& navigator) {
  const auto dock = std::ranges::find(*docks_, status_.dock, &Dock::name);
  if (!IsDocked() || dock == docks_->end() || IsLost(navigator.mode())) {
    sight_.ForgetLearned();
    return;
  }
  if (!dock->view.empty()) return;
  learned_ = sight_.Learn(*dock, navigator.Snapshot());
  if (!learned_.has_value()) return;
  std::vector<Dock> docks = *docks_;
  docks[static_cast<size_t>(dock - docks_->begin())] = *learned_;
  docks_ = std::make_shared<const std::vector<Dock>>(std::move(docks));
  events_.Add("dock", absl::StrCat("knows what is seen from dock '",
                                   learned_->name, "'"));
}

void DockPilot::LookForDock(const behavior::Navigator& navigator) {
  seen_ = sight_.Look(dock_, navigator.Snapshot(), now_);
  if (is_move_told_ || !sight_.seen().has_value() ||
      sight_.seen()->moved_m == 0) {
    return;
  }
  is_move_told_ = true;
  events_.Add("dock",
              absl::StrFormat("dock '%s' was moved by %.1f cm: follows",
                              dock_.name, 100 * sight_.seen()->moved_m));
}

// ---- all ----

void DockPilot::LookWhereItIs(const behavior::Navigator& navigator) {
  if (looked_.has_value() &&
      base::SecondsBetween(*looked_, now_) < kLookEvery_s) {
    return;
  }
  looked_ = now_;
  const bool was_docked = IsDocked();
  status_.state = DockingState::kAway;
  const std::string before = std::exchange(status_.dock, "");
  if (docks_->empty() || IsLost(navigator.mode())) return;
  const std::optional<core::LevelPose> robot = PoseOf(navigator);
  if (!robot.has_value()) return;
  for (const Dock& dock : *docks_) {
    if (!IsAt(dock, *robot)) continue;
    status_.state = DockingState::kDocked;
    status_.dock = dock.name;
    if (!was_docked || before != dock.name) {
      events_.Add("dock", absl::StrCat("stands in dock '", dock.name, "'"));
    }
    return;
  }
}

bool DockPilot::IsSteered() const {
  return status_.state == DockingState::kDrivingIn ||
         status_.state == DockingState::kTouching ||
         status_.state == DockingState::kBackingOut ||
         status_.state == DockingState::kDrivingOut;
}

void DockPilot::Steer(behavior::Navigator& navigator, const Dock& dock,
                      const core::VelocityCommand& wanted,
                      const std::string& what) {
  const absl::Status steered = navigator.Steer(
      {.wanted = wanted,
       .docked = OnLevel(dock, dock.map_from_docked),
       .is_backward = dock.is_backward,
       .is_leaving = status_.state == DockingState::kBackingOut ||
                     status_.state == DockingState::kDrivingOut,
       .what = what});
  if (steered.ok()) return;
  if (status_.state == DockingState::kDrivingOut) {
    Release(navigator);
    EndOut(std::string(steered.message()));
  } else {
    (void)navigator.CancelGoal(goal_id_);
    End(DockingOutcome::kFailed, std::string(steered.message()));
  }
}

void DockPilot::Release(const behavior::Navigator& navigator) {
  const std::optional<behavior::GoalStatus> goal = navigator.goal();
  if (goal.has_value()) released_goal_ = goal->id;
}

void DockPilot::Enter(DockingState state) {
  status_.state = state;
  got_on_.reset();
  contact_along_m_.reset();
  is_straight_ = false;
}

void DockPilot::NoteProgress(double along_m, double turned_rad) {
  if (got_on_.has_value() && along_m < best_.along_m + kGotOn_m &&
      std::abs(turned_rad) > std::abs(best_.turned_rad) - kGotOn_rad) {
    return;
  }
  best_ = {.along_m = along_m, .aside_m = 0, .turned_rad = turned_rad};
  got_on_ = now_;
}

double DockPilot::Stood_s() const {
  return got_on_.has_value() ? base::SecondsBetween(*got_on_, now_) : 0;
}

std::optional<core::LevelPose> DockPilot::PoseOf(
    const behavior::Navigator& navigator) const {
  const std::optional<localization::TrackedPose> pose =
      navigator.Snapshot().pose;
  if (!pose.has_value()) return std::nullopt;
  return pose->pose;
}

}  // namespace treeline::docking

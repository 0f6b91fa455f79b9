#include "nav_agent/docking/charge_keeper.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/docking/parameters.h"

namespace treeline::docking {
namespace {

using behavior::GoalState;
using behavior::NavigatorMode;

bool IsActive(const std::optional<behavior::GoalStatus>& goal) {
  return goal.has_value() && (goal->state == GoalState::kAccepted ||
                              goal->state == GoalState::kActive);
}

// Whether something has held for so long; `since` remembers from when on.
bool HoldsFor(bool holds, double seconds, base::MonotonicTime now,
              std::optional<base::MonotonicTime>& since) {
  if (!holds) {
    since.reset();
    return false;
  }
  if (!since.has_value()) since = now;
  return base::SecondsBetween(*since, now) >= seconds;
}

}  // namespace

absl::Status ChargeOptions::Validate() const {
  if (!(below >= 0 && below < 1 && until > below && until <= 1)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "it charges below %.0f %% until %.0f %%: the first must be 0 to 99, "
        "the second above it and at most 100",
        100 * below, 100 * until));
  }
  return absl::OkStatus();
}

void ChargeKeeper::Set(ChargeState state, std::string why) {
  status_ = {.state = state, .why = std::move(why)};
}

std::string ChargeKeeper::ChargeText(const Look& look) const {
  return look.charge.has_value()
             ? absl::StrFormat("the battery is at %.0f %%", 100 * *look.charge)
             : std::string("the battery does not tell its charge");
}

void ChargeKeeper::Step(behavior::Navigator& navigator, DockPilot& pilot,
                        routes::RouteRunner& runner, base::MonotonicTime now,
                        const std::optional<core::Battery>& battery) {
  events_.SetTime(now);
  Look look = {.navigator = navigator,
               .pilot = pilot,
               .runner = runner,
               .now = now,
               .mode = navigator.mode(),
               .has_goal = IsActive(navigator.goal())};
  if (battery.has_value()) {
    look.charging = battery->charging;
    // Also for what is not a number.
    if (battery->charge.value_or(-1) >= 0 && *battery->charge <= 1) {
      look.charge = battery->charge;
    }
  }
  NoteOrders(look);
  if (status_.state == ChargeState::kGoing) {
    StepGoing(look);
  } else if (status_.state == ChargeState::kCharging) {
    StepCharging(look);
  } else {
    StepWatching(look);
  }
}

void ChargeKeeper::NoteOrders(const Look& look) {
  const std::optional<behavior::GoalStatus> goal = look.navigator.goal();
  if (goal.has_value() && goal->id != seen_goal_) {
    seen_goal_ = goal->id;
    if (goal->id != look.pilot.goal_id()) put_off_.clear();
  }
  if (look.mode == NavigatorMode::kStopped) put_off_ = "the robot was stopped";
  if (look.mode == NavigatorMode::kManual) {
    put_off_ = "the robot was driven by hand";
  }
  if (look.charge.has_value() && *look.charge >= options_.below) {
    kept_route_ = 0;
  }
}

// ---- whether it goes ----

bool ChargeKeeper::IsLow(const Look& look) {
  return HoldsFor(look.charge.has_value() && *look.charge < options_.below,
                  kLow_s, look.now, low_since_);
}

void ChargeKeeper::StepWatching(const Look& look) {
  if (options_.below <= 0 || look.pilot.docks()->empty()) {
    Set(ChargeState::kOff, options_.below <= 0 ? "" : "there is no dock");
    return;
  }
  const bool is_idle =
      HoldsFor(look.mode == NavigatorMode::kIdle && !look.has_goal &&
                   !look.runner.IsUnderWay() && !look.pilot.IsUnderWay(),
               kIdle_s, look.now, idle_since_);
  const bool is_low = IsLow(look);
  if (!look.charge.has_value()) {
    Set(ChargeState::kUnknown, "the battery does not tell its charge");
    return;
  }
  if (look.pilot.IsCharging() && *look.charge < options_.until) {
    left_route_ = 0;
    Set(ChargeState::kCharging);
    events_.Add("charge", absl::StrCat("charges: ", ChargeText(look)));
    return;
  }
  if (!is_low) {
    Set(ChargeState::kEnough);
    return;
  }
  if (!is_idle && !look.runner.IsUnderWay()) {
    Set(ChargeState::kLow, "what the robot does now comes first");
    return;
  }
  std::string why_not = WhyNot(look);
  if (why_not.empty()) {
    Go(look);
  } else {
    if (status_.state != ChargeState::kLow || status_.why != why_not) {
      events_.Add("charge",
                  absl::StrCat(ChargeText(look),
                               ", and it does not go to charge: ", why_not));
    }
    Set(ChargeState::kLow, std::move(why_not));
  }
}

std::string ChargeKeeper::WhyNot(const Look& look) const {
  if (!put_off_.empty()) {
    return absl::StrCat(put_off_, "; Resume, or a goal, lets it go");
  }
  const auto& route = look.runner.status();
  if (look.runner.IsUnderWay() && route->id == kept_route_) {
    return "somebody resumed its route";
  }
  if (retry_at_.has_value() && look.now < *retry_at_) return retry_why_;
  if (look.mode != NavigatorMode::kIdle &&
      look.mode != NavigatorMode::kDriving &&
      look.mode != NavigatorMode::kPlanning &&
      look.mode != NavigatorMode::kRecovering) {
    return absl::StrCat("the robot is ", NavigatorModeName(look.mode));
  }
  return "";
}

// ---- a trip ----

void ChargeKeeper::Go(const Look& look) {
  retry_at_.reset();
  candidates_.clear();
  const auto pose = look.navigator.Snapshot().pose;
  std::vector<std::pair<double, std::string>> away;
  for (const Dock& dock : *look.pilot.docks()) {
    double away_m = 0;
    if (pose.has_value()) {
      away_m = Away_m(dock, pose->pose);
    }
    away.emplace_back(-away_m, dock.name);
  }
  std::ranges::stable_sort(away, {}, &std::pair<double, std::string>::first);
  for (auto& [unused, name] : away) candidates_.push_back(std::move(name));
  ++trips_;
  left_route_ = 0;
  if (look.runner.IsUnderWay()) {
    left_route_ = look.runner.status()->id;
    look.runner.Hold(absl::StrCat(ChargeText(look), ": it goes to charge"));
  }
  events_.Add("charge", absl::StrCat(ChargeText(look), ": goes to charge"));
  retry_why_.clear();
  if (!TryNext(look)) GiveUp(look, "no dock can be driven to");
}

bool ChargeKeeper::TryNext(const Look& look) {
  while (!candidates_.empty()) {
    const std::string name = std::move(candidates_.back());
    candidates_.pop_back();
    const auto& docks = *look.pilot.docks();
    const auto dock = std::ranges::find(docks, name, &Dock::name);
    if (dock == docks.end()) continue;
    const absl::StatusOr<uint64_t> begun =
        look.pilot.Begin(look.navigator, *dock);
    if (begun.ok()) {
      docking_ = *begun;
      Set(ChargeState::kGoing, absl::StrCat("to dock '", name, "'"));
      return true;
    }
    retry_why_ = std::string(begun.status().message());
  }
  return false;
}

void ChargeKeeper::StepGoing(const Look& look) {
  const DockingStatus& docking = look.pilot.status();
  if (docking.id != docking_) {
    Set(ChargeState::kEnough);
    events_.Add("charge", "somebody sent it to a dock");
    return;
  }
  switch (docking.outcome) {
    case DockingOutcome::kSucceeded:
      not_charging_since_.reset();
      Set(ChargeState::kCharging);
      events_.Add("charge", absl::StrCat("charges: ", ChargeText(look)));
      break;
    case DockingOutcome::kFailed:
      retry_why_ = docking.why;
      if (!TryNext(look)) GiveUp(look, retry_why_);
      break;
    case DockingOutcome::kCancelled:
      // A goal says what the robot does now; all else, that it stands.
      if (!look.has_goal) put_off_ = docking.why;
      events_.Add("charge", absl::StrCat("is on its way to a dock no more: ",
                                         docking.why));
      if (look.runner.IsUnderWay()) kept_route_ = look.runner.status()->id;
      Set(ChargeState::kLow, docking.why);
      break;
    default:
      break;
  }
}

void ChargeKeeper::GiveUp(const Look& look, const std::string& why) {
  retry_why_ = absl::StrFormat(
      "no dock could be reached: %s; it tries again "
      "after %.0f s",
      why, kRetry_s.value);
  retry_at_ =
      look.now + std::chrono::duration_cast<base::MonotonicTime::duration>(
                     std::chrono::duration<double>(kRetry_s.value));
  events_.Add("charge", retry_why_);
  Set(ChargeState::kLow, retry_why_);
  GoOnWithRoute(look);
}

void ChargeKeeper::StepCharging(const Look& look) {
  if (!look.pilot.IsDocked()) {
    events_.Add("charge", absl::StrCat("charges no more, it left its dock: ",
                                       ChargeText(look)));
    if (look.runner.IsUnderWay()) kept_route_ = look.runner.status()->id;
    Set(ChargeState::kLow, "it left its dock");
    return;
  }
  if (look.charge.has_value() && *look.charge >= options_.until) {
    events_.Add("charge", absl::StrCat("has charged: ", ChargeText(look)));
    Set(ChargeState::kEnough);
    GoOnWithRoute(look);
    return;
  }
  Set(ChargeState::kCharging,
      look.charge.has_value() ? "" : "the battery does not tell its charge");
  if (!HoldsFor(look.charging == core::Charging::kNo, 2 * kContact_s, look.now,
                not_charging_since_)) {
    return;
  }
  not_charging_since_.reset();
  events_.Add("charge", "the contact is lost: docks again");
  candidates_ = {look.pilot.status().dock};
  if (!TryNext(look)) GiveUp(look, retry_why_);
}

void ChargeKeeper::GoOnWithRoute(const Look& look) {
  const uint64_t left = std::exchange(left_route_, 0);
  if (left == 0 || !look.runner.IsHeld() || look.runner.status()->id != left) {
    return;
  }
  const absl::Status resumed = look.runner.Resume(look.navigator);
  if (!resumed.ok()) events_.Add("charge", std::string(resumed.message()));
}

}  // namespace treeline::docking

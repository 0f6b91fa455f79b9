// Sends a robot to its dock when its battery is low, and lets it go on with its
// route when it has charged.
#ifndef NAV_AGENT_DOCKING_CHARGE_KEEPER_H_
#define NAV_AGENT_DOCKING_CHARGE_KEEPER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "nav_agent/docking/dock_pilot.h"
#include "nav_agent/routes/route_runner.h"

namespace treeline::docking {

struct ChargeOptions {
  // Of a full battery, in [0, 1): below this it goes to charge; 0: never.
  double below = 0.2;
  // In (below, 1]: then it has charged enough.
  double until = 0.9;

  absl::Status Validate() const;
};

// A robot that is on a route leaves it at once, and takes it up again where it
// was; one that drives to a goal drives there first; one that stands waits for
// kIdle_s. It goes to the nearest dock that it can reach. What people say goes
// before that: another goal, or a route that is resumed, ends a trip to a dock,
// and a charge; the goal or the route that did so is not interrupted again.
// After a stop, a cancelled trip, a drive by hand and the agent's start nothing
// moves by this until somebody says Resume, or sends the robot somewhere. A
// battery that does not tell its charge makes nothing happen.
//
// Not thread-safe: everything is called by the thread that steps the navigator.
class ChargeKeeper {
 public:
  explicit ChargeKeeper(const ChargeOptions& options) : options_(options) {}

  // After each step of `runner`, and before that of `pilot`, which are above
  // `navigator`.
  void Step(behavior::Navigator& navigator, DockPilot& pilot,
            routes::RouteRunner& runner, base::MonotonicTime now,
            const std::optional<core::Battery>& battery);
  // Somebody said so.
  void Resume() { put_off_.clear(); }

  const ChargeStatus& status() const { return status_; }
  // Trips to a dock so far.
  int64_t trips() const { return trips_; }
  // "charge", since the last call.
  std::vector<behavior::NavigatorEvent> TakeEvents() { return events_.Take(); }

 private:
  // What a step looks at.
  struct Look {
    behavior::Navigator& navigator;
    DockPilot& pilot;
    routes::RouteRunner& runner;
    base::MonotonicTime now;
    std::optional<double> charge = std::nullopt;
    core::Charging charging = core::Charging::kUnknown;
    behavior::NavigatorMode mode = behavior::NavigatorMode::kIdle;
    bool has_goal = false;
  };

  void NoteOrders(const Look& look);
  void StepWatching(const Look& look);
  // Why it does not go now; empty: it may.
  std::string WhyNot(const Look& look) const;
  bool IsLow(const Look& look);
  void Go(const Look& look);
  // The next of `candidates_` that can be begun with; false: there is none.
  bool TryNext(const Look& look);
  void StepGoing(const Look& look);
  void StepCharging(const Look& look);
  void GiveUp(const Look& look, const std::string& why);
  void GoOnWithRoute(const Look& look);
  void Set(ChargeState state, std::string why = "");
  std::string ChargeText(const Look& look) const;

  ChargeOptions options_;
  behavior::EventLog events_;
  ChargeStatus status_;
  // Why it goes nowhere before somebody says so; empty: it may.
  std::string put_off_ = "the agent has begun, and nobody has sent it anywhere";
  std::optional<base::MonotonicTime> low_since_;
  std::optional<base::MonotonicTime> idle_since_;
  std::optional<base::MonotonicTime> retry_at_;
  std::string retry_why_;
  uint64_t seen_goal_ = 0;
  // ---- a trip ----
  // Names of docks, the next one last.
  std::vector<std::string> candidates_;
  uint64_t docking_ = 0;
  int64_t trips_ = 0;
  // The route that it left; and one that is not left again. 0: none.
  uint64_t left_route_ = 0;
  uint64_t kept_route_ = 0;
  std::optional<base::MonotonicTime> not_charging_since_;
};

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_CHARGE_KEEPER_H_

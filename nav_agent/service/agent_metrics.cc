#include "nav_agent/service/agent_metrics.h"

#include <array>
#include <vector>

#include "common/base/version.h"
#include "nav_agent/service/api_json.h"

namespace treeline::agent_service {
namespace {

constexpr std::array<behavior::NavigatorMode, 11> kModes = {
    behavior::NavigatorMode::kIdle,     behavior::NavigatorMode::kPlanning,
    behavior::NavigatorMode::kDriving,  behavior::NavigatorMode::kRecovering,
    behavior::NavigatorMode::kLost,     behavior::NavigatorMode::kRelocalizing,
    behavior::NavigatorMode::kPaused,   behavior::NavigatorMode::kSafeStop,
    behavior::NavigatorMode::kNeedHelp, behavior::NavigatorMode::kStopped,
    behavior::NavigatorMode::kManual,
};

// About the 25 ms of the control loop (s).
std::vector<double> PeriodBuckets() {
  return {0.005, 0.01, 0.02,  0.024, 0.026, 0.03,
          0.04,  0.05, 0.075, 0.1,   0.2,   0.5};
}

std::vector<double> StepBuckets() {
  return {0.0005, 0.001, 0.002, 0.004, 0.006, 0.008,
          0.012,  0.018, 0.025, 0.05,  0.1,   0.3};
}

bool IsOver(behavior::GoalState state) {
  return state == behavior::GoalState::kSucceeded ||
         state == behavior::GoalState::kFailed ||
         state == behavior::GoalState::kCancelled;
}

}  // namespace

AgentMetrics::AgentMetrics()
    : goals_(&registry_.AddCounter("treeline_agent_goals_total",
                                   "Finished goals, by outcome and cause",
                                   {"outcome", "cause"})),
      events_(&registry_.AddCounter("treeline_agent_events_total",
                                    "Events of the navigator", {"kind"})),
      fixes_(&registry_.AddCounter(
          "treeline_agent_fixes_total",
          "Answers of the relocalization server, by the gate's verdict",
          {"verdict"})),
      devices_(&registry_.AddGauge("treeline_agent_device_up",
                                   "1 while the device runs", {"device"})),
      modes_(&registry_.AddGauge("treeline_agent_mode",
                                 "1 for the robot's present mode", {"mode"})),
      battery_volts_(&registry_.AddGauge("treeline_agent_battery_volts",
                                         "Of the robot's battery, V", {})),
      battery_charge_(&registry_.AddGauge("treeline_agent_battery_charge_ratio",
                                          "Of a full battery, in [0, 1]", {})),
      dockings_(&registry_.AddCounter("treeline_agent_dockings_total",
                                      "Finished dockings, by outcome",
                                      {"outcome"})),
      charge_trips_(
          &registry_
               .AddCounter("treeline_agent_charge_trips_total",
                           "Trips to a dock for a battery that was low", {})
               .With({})),
      docked_(&registry_
                   .AddGauge("treeline_agent_docked",
                             "1 while the robot stands in a dock", {})
                   .With({})),
      routes_(&registry_.AddCounter("treeline_agent_routes_total",
                                    "Finished routes, by outcome",
                                    {"outcome"})),
      waypoints_(&registry_.AddCounter(
          "treeline_agent_waypoints_total",
          "Waypoints of routes, reached and missed", {"outcome"})),
      recoveries_(&registry_
                       .AddCounter("treeline_agent_recoveries_total",
                                   "Recovery behaviours that were run", {})
                       .With({})),
      replans_(&registry_
                    .AddCounter("treeline_agent_replans_total",
                                "Plans that replaced another one", {})
                    .With({})),
      lost_(&registry_
                 .AddCounter("treeline_agent_lost_total",
                             "Times that the robot declared itself lost", {})
                 .With({})),
      missed_(&registry_
                   .AddCounter("treeline_agent_missed_deadlines_total",
                               "Control steps that began a period late", {})
                   .With({})),
      lost_probability_(
          &registry_
               .AddGauge("treeline_agent_lost_probability",
                         "Probability that the robot's estimated pose is wrong",
                         {})
               .With({})),
      driven_(&registry_
                   .AddGauge("treeline_agent_driven_meters",
                             "Distance driven for goals since the start, m", {})
                   .With({})),
      period_(&registry_
                   .AddHistogram("treeline_agent_control_period_seconds",
                                 "From the start of one control step to the "
                                 "start of the next",
                                 {}, PeriodBuckets())
                   .With({})),
      step_(&registry_
                 .AddHistogram("treeline_agent_step_seconds",
                               "Duration of the robot's part of a control step",
                               {}, StepBuckets())
                 .With({})),
      round_trip_(&registry_
                       .AddHistogram("treeline_agent_fix_round_trip_seconds",
                                     "From a query to the server to its answer",
                                     {}, metrics::LatencyBuckets())
                       .With({})) {
  registry_
      .AddGauge("treeline_agent_info", "Always 1; the version is its label",
                {"version"})
      .With({base::Version()})
      .Set(1);
}

void AgentMetrics::ObserveStep(std::optional<double> period_s, double step_s) {
  if (period_s.has_value()) period_->Observe(*period_s);
  step_->Observe(step_s);
}

void AgentMetrics::ObserveState(const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  for (const DeviceReport& device : state.devices) {
    devices_->With({device.name}).Set(device.state == "running" ? 1 : 0);
  }
  for (const behavior::NavigatorMode mode : kModes) {
    modes_->With({behavior::NavigatorModeName(mode)})
        .Set(mode == snapshot.mode ? 1 : 0);
  }
  lost_probability_->Set(snapshot.verdict.probability);
  const bool is_lost =
      snapshot.mode == behavior::NavigatorMode::kLost ||
      snapshot.mode == behavior::NavigatorMode::kRelocalizing ||
      snapshot.mode == behavior::NavigatorMode::kNeedHelp;
  if (is_lost && !was_lost_) lost_->Add();
  was_lost_ = is_lost;
  if (state.battery.has_value() && state.battery->voltage_v > 0) {
    battery_volts_->With({}).Set(state.battery->voltage_v);
  }
  if (state.battery.has_value() && state.battery->charge.has_value()) {
    battery_charge_->With({}).Set(*state.battery->charge);
  }
  ObserveGoal(snapshot.goal);
  ObserveFix(snapshot);
  ObserveRoute(state.route);
  ObserveDocks(state.docks);
}

void AgentMetrics::ObserveDocks(const DockReport& docks) {
  docked_->Set(docks.docking.state == docking::DockingState::kDocked ? 1 : 0);
  if (docks.charge_trips > counted_trips_) {
    charge_trips_->Add(
        static_cast<uint64_t>(docks.charge_trips - counted_trips_));
    counted_trips_ = docks.charge_trips;
  }
  if (docks.docking.id == counted_docking_ ||
      docks.docking.outcome == docking::DockingOutcome::kUnderWay) {
    return;
  }
  counted_docking_ = docks.docking.id;
  dockings_->With({docking::DockingOutcomeName(docks.docking.outcome)}).Add();
}

void AgentMetrics::ObserveRoute(
    const std::optional<routes::RouteStatus>& route) {
  if (!route.has_value()) return;
  const routes::RouteProgress& progress = route->progress;
  if (route->id != route_) {
    route_ = route->id;
    // What was before a restart is not counted again.
    const bool is_old = route->state == routes::RouteState::kOffered;
    route_reached_ = is_old ? progress.reached : 0;
    route_missed_ = is_old ? progress.missed : 0;
  }
  const auto count = [this](const char* outcome, int64_t now, int64_t& so_far) {
    if (now <= so_far) return;
    waypoints_->With({outcome}).Add(static_cast<uint64_t>(now - so_far));
    so_far = now;
  };
  count("reached", progress.reached, route_reached_);
  count("missed", progress.missed, route_missed_);
  if (routes::IsOver(route->state) && route->id != counted_route_) {
    counted_route_ = route->id;
    routes_->With({routes::RouteStateName(route->state)}).Add();
  }
}

void AgentMetrics::ObserveGoal(
    const std::optional<behavior::GoalStatus>& goal) {
  if (!goal.has_value()) return;
  if (goal->id != goal_) {
    driven_before_m_ += goal_driven_m_;
    goal_ = goal->id;
    goal_recoveries_ = 0;
    goal_replans_ = 0;
  }
  if (goal->recoveries > goal_recoveries_) {
    recoveries_->Add(
        static_cast<uint64_t>(goal->recoveries - goal_recoveries_));
    goal_recoveries_ = goal->recoveries;
  }
  if (goal->replans > goal_replans_) {
    replans_->Add(static_cast<uint64_t>(goal->replans - goal_replans_));
    goal_replans_ = goal->replans;
  }
  goal_driven_m_ = goal->driven_m;
  driven_->Set(driven_before_m_ + goal_driven_m_);
  if (IsOver(goal->state) && goal->id != counted_goal_) {
    counted_goal_ = goal->id;
    goals_
        ->With({GoalStateName(goal->state),
                core::NavigationCauseName(goal->cause)})
        .Add();
  }
}

void AgentMetrics::ObserveFix(const behavior::NavigatorSnapshot& snapshot) {
  if (!snapshot.fix.has_value() || snapshot.fix_verdict.empty()) return;
  const bool is_new = counted_fix_ != snapshot.fix->stamp;
  if (!is_new && counted_verdict_ == snapshot.fix_verdict) return;
  if (is_new) round_trip_->Observe(snapshot.fix->round_trip_s);
  counted_fix_ = snapshot.fix->stamp;
  counted_verdict_ = snapshot.fix_verdict;
  // Up to its first ':' a verdict is a word of ours.
  fixes_->With({snapshot.fix_verdict.substr(0, snapshot.fix_verdict.find(':'))})
      .Add();
}

}  // namespace treeline::agent_service

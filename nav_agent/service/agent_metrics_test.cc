#include "nav_agent/service/agent_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

behavior::GoalStatus GoalOf(uint64_t id, behavior::GoalState state,
                            double driven_m, int recoveries) {
  behavior::GoalStatus goal;
  goal.id = id;
  goal.state = state;
  goal.driven_m = driven_m;
  goal.recoveries = recoveries;
  return goal;
}

TEST(AgentMetrics, CountsAGoalOnce) {
  AgentMetrics metrics;
  AgentState state;
  state.snapshot.goal = GoalOf(1, behavior::GoalState::kActive, 2, 1);
  metrics.ObserveState(state);
  EXPECT_THAT(metrics.Expose(), Not(HasSubstr("agent_goals_total{")));
  state.snapshot.goal->state = behavior::GoalState::kSucceeded;
  state.snapshot.goal->recoveries = 3;
  metrics.ObserveState(state);
  metrics.ObserveState(state);
  state.snapshot.goal = GoalOf(2, behavior::GoalState::kFailed, 0.5, 1);
  state.snapshot.goal->cause = core::NavigationCause::kNoPath;
  metrics.ObserveState(state);
  const std::string text = metrics.Expose();
  EXPECT_THAT(text,
              HasSubstr("treeline_agent_goals_total{outcome=\"succeeded\","
                        "cause=\"none\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_goals_total{outcome=\"failed\","
                              "cause=\"no_path\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_recoveries_total 4\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_driven_meters 2.5\n"));
}

TEST(AgentMetrics, CountsRoutesAndWaypointsButNotThoseBeforeARestart) {
  AgentMetrics metrics;
  AgentState state;
  state.route = routes::RouteStatus{
      .id = 1,
      .state = routes::RouteState::kOffered,
      .progress = {.route = std::make_shared<const routes::Route>(),
                   .reached = 5,
                   .missed = 2}};
  metrics.ObserveState(state);
  EXPECT_THAT(metrics.Expose(), Not(HasSubstr("agent_waypoints_total{")));
  state.route->state = routes::RouteState::kDriving;
  state.route->progress.reached = 7;
  metrics.ObserveState(state);
  state.route->state = routes::RouteState::kSucceeded;
  state.route->progress.missed = 3;
  metrics.ObserveState(state);
  metrics.ObserveState(state);
  const std::string text = metrics.Expose();
  EXPECT_THAT(
      text,
      HasSubstr("treeline_agent_waypoints_total{outcome=\"reached\"} 2\n"));
  EXPECT_THAT(
      text,
      HasSubstr("treeline_agent_waypoints_total{outcome=\"missed\"} 1\n"));
  EXPECT_THAT(
      text,
      HasSubstr("treeline_agent_routes_total{outcome=\"succeeded\"} 1\n"));
}

TEST(AgentMetrics, DockingsAndTripsAreCountedOnce) {
  AgentMetrics metrics;
  AgentState state;
  metrics.ObserveState(state);
  EXPECT_THAT(metrics.Expose(),
              Not(HasSubstr("\ntreeline_agent_dockings_total{")));
  state.docks.docking = {.id = 1,
                         .outcome = docking::DockingOutcome::kUnderWay};
  state.docks.charge_trips = 1;
  metrics.ObserveState(state);
  state.docks.docking.outcome = docking::DockingOutcome::kSucceeded;
  state.docks.docking.state = docking::DockingState::kDocked;
  metrics.ObserveState(state);
  metrics.ObserveState(state);
  const std::string text = metrics.Expose();
  EXPECT_THAT(
      text,
      HasSubstr("treeline_agent_dockings_total{outcome=\"succeeded\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_charge_trips_total 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_docked 1\n"));
}

TEST(AgentMetrics, ABatteryThatTellsNothingIsNotShown) {
  AgentMetrics metrics;
  AgentState state;
  metrics.ObserveState(state);
  state.battery = core::Battery{.voltage_v = 74.5};
  metrics.ObserveState(state);
  EXPECT_THAT(metrics.Expose(),
              HasSubstr("treeline_agent_battery_volts 74.5\n"));
  EXPECT_THAT(metrics.Expose(),
              Not(HasSubstr("\ntreeline_agent_battery_charge_ratio ")));
  state.battery->charge = 0.25;
  metrics.ObserveState(state);
  EXPECT_THAT(metrics.Expose(),
              HasSubstr("treeline_agent_battery_charge_ratio 0.25\n"));
}

TEST(AgentMetrics, CountsTimesLostAndFixes) {
  AgentMetrics metrics;
  AgentState state;
  for (const behavior::NavigatorMode mode :
       {behavior::NavigatorMode::kDriving, behavior::NavigatorMode::kLost,
        behavior::NavigatorMode::kRelocalizing,
        behavior::NavigatorMode::kDriving, behavior::NavigatorMode::kLost}) {
    state.snapshot.mode = mode;
    metrics.ObserveState(state);
  }
  state.snapshot.fix.emplace();
  state.snapshot.fix->round_trip_s = 0.02;
  state.snapshot.fix_verdict = "refused: 0.4 m above the floor";
  metrics.ObserveState(state);
  metrics.ObserveState(state);
  const std::string text = metrics.Expose();
  EXPECT_THAT(text, HasSubstr("treeline_agent_lost_total 2\n"));
  EXPECT_THAT(text,
              HasSubstr("treeline_agent_fixes_total{verdict=\"refused\"} 1\n"));
  EXPECT_THAT(text,
              HasSubstr("treeline_agent_fix_round_trip_seconds_count 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_mode{mode=\"lost\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_mode{mode=\"driving\"} 0\n"));
}

TEST(AgentMetrics, TellsStepsAndDevices) {
  AgentMetrics metrics;
  metrics.ObserveStep(std::nullopt, 0.003);
  metrics.ObserveStep(0.0251, 0.003);
  metrics.CountMissedDeadline();
  metrics.CountEvent("goal");
  AgentState state;
  state.devices = {{"laser", "running", ""}, {"base", "lost", "unplugged"}};
  metrics.ObserveState(state);
  const std::string text = metrics.Expose();
  EXPECT_THAT(text,
              HasSubstr("treeline_agent_control_period_seconds_count 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_step_seconds_count 2\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_missed_deadlines_total 1\n"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_events_total{kind=\"goal\"} 1"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_device_up{device=\"laser\"} 1"));
  EXPECT_THAT(text, HasSubstr("treeline_agent_device_up{device=\"base\"} 0"));
}

}  // namespace
}  // namespace treeline::agent_service

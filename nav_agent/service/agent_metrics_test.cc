#include "nav_agent/service/agent_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nav_agent/service/testing_navigator.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(AgentMetrics, CountsAGoalOnce) {
  AgentMetrics metrics;
  AgentState state;
  state.snapshot.goal = GoalStatus{
      .id = 1, .state = GoalState::kActive, .driven_m = 2, .recoveries = 1};
  metrics.ObserveState(state);
  EXPECT_THAT(metrics.Expose(), Not(HasSubstr("agent_goals_total{")));
  state.snapshot.goal->state = GoalState::kSucceeded;
  state.snapshot.goal->recoveries = 3;
  metrics.ObserveState(state);
  metrics.ObserveState(state);
  state.snapshot.goal = GoalStatus{.id = 2,
                                   .state = GoalState::kFailed,
                                   .cause = NavigationCause::kNoPath,
                                   .driven_m = 0.5,
                                   .recoveries = 1};
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

TEST(AgentMetrics, CountsTimesLostAndFixes) {
  AgentMetrics metrics;
  AgentState state;
  for (const NavigatorMode mode :
       {NavigatorMode::kDriving, NavigatorMode::kLost,
        NavigatorMode::kRelocalizing, NavigatorMode::kDriving,
        NavigatorMode::kLost}) {
    state.snapshot.mode = mode;
    metrics.ObserveState(state);
  }
  state.snapshot.fix = RelocalizationAnswer{.localized = true};
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
}  // namespace treeline

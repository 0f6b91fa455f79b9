// A robot whose battery is low when its route begins: into its dock, and back.
#include <gmock/gmock.h>
#include <signal.h>

#include <string>
#include <vector>

#include "common/base/file.h"
#include "tests/integration/agent_run_fixture.h"

namespace treeline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// 5 m from where it starts. In the simulated cafe a charger stands there: it
// charges where contacts meet, within 3 cm of the dock's pose.
TEST_F(AgentRunTest, ALowBatteryIsChargedAndTheRouteGoesOn) {
  const std::vector<std::string> arguments = {"--simulate",
                                              "cafe",
                                              "--people=false",
                                              "--camera-hz",
                                              "0",
                                              "--speed",
                                              "4",
                                              "--state-dir",
                                              folder_ + "/state",
                                              "--battery-at",
                                              "15",
                                              "--battery-lasts-s",
                                              "400",
                                              "--charge-until",
                                              "26"};
  ASSERT_NO_FATAL_FAILURE(StartAgent(arguments));
  EXPECT_THAT(Ask({"dock", "save", "wall", "--at", "-30,0,0"}, 1),
              HasSubstr("dock 'wall': its docked pose (-30.00, 0.00) lies "
                        "outside of the map"));
  Ask({"dock", "save", "charger", "--at", "6.5,7.7,0"});
  EXPECT_THAT(Ask({"dock", "list"}),
              HasSubstr("charger: at (6.500, 7.700), 0.000 rad, level 0, "
                        "forward from 0.83 m\n"));
  EXPECT_THAT(Ask({"dock", "out"}, 1), HasSubstr("the robot is in no dock"));
  const std::string file = folder_ + "/routes.yaml";
  ASSERT_TRUE(base::WriteNewFile(file,
                                 "routes:\n"
                                 "  - name: rounds\n"
                                 "    waypoints:\n"
                                 // Three metres: longer than it takes to be
                                 // sure that the battery is low.
                                 "      - {x: 4.6, y: 7.7}\n"
                                 "      - {x: 2.6, y: 7.7}\n")
                  .ok());
  Ask({"route", "save", file});
  const std::string told = Ask({"route", "run", "rounds", "--quiet"});
  EXPECT_THAT(told, HasSubstr("2 waypoints reached")) << agent_->err();
  EXPECT_THAT(agent_->err(),
              AllOf(HasSubstr("is held at waypoint 1 of 2"),
                    HasSubstr("docked in 'charger': it charges"),
                    HasSubstr("has charged: the battery is at 26 %"),
                    HasSubstr("is out of dock 'charger'")));
  EXPECT_THAT(
      httplib::Client(page_).Get("/metrics")->body,
      AllOf(
          HasSubstr("treeline_agent_charge_trips_total 1"),
          HasSubstr("treeline_agent_dockings_total{outcome=\"succeeded\"} 1")));
  // Again, by hand; a restart finds the dock, and the robot in it.
  EXPECT_THAT(Ask({"dock", "go", "charger", "--quiet"}),
              HasSubstr("docked in charger: it charges"));
  const nlohmann::json docked = Get("/api/state");
  // The contacts' reach.
  EXPECT_NEAR(docked["truth"]["x"], 6.5, 0.03);
  EXPECT_NEAR(docked["truth"]["y"], 7.7, 0.03);
  agent_->Signal(SIGKILL);
  agent_->WaitForExit();
  std::vector<std::string> again = arguments;
  again.insert(again.end(), {"--start-at", "6.48,7.7,0"});
  ASSERT_NO_FATAL_FAILURE(StartAgent(again));
  const v1::NavigateResponse last = DriveTo(4.6, 7.7);
  EXPECT_EQ(last.goal().state(), v1::GOAL_STATE_SUCCEEDED) << last.goal().why();
  EXPECT_THAT(agent_->err(), HasSubstr("is out of dock 'charger'"));
}

}  // namespace
}  // namespace treeline

// treeline-agent run as people run it: a robot in simulated time, and one whose
// laser and base are emulated byte for byte, driven through gRPC and HTTP.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "tests/integration/agent_run_fixture.h"

namespace treeline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

TEST_F(AgentRunTest, ASimulatedRobotDrivesToItsGoalAndStopsOnInterrupt) {
  ASSERT_NO_FATAL_FAILURE(
      StartAgent({"--simulate", "cafe", "--people=false", "--camera-hz", "0",
                  "--speed", "4", "--record", folder_ + "/run.tlog"}));
  const v1::NavigateResponse last = DriveTo(kGoalX_m, kGoalY_m);
  EXPECT_EQ(last.goal().state(), v1::GOAL_STATE_SUCCEEDED)
      << last.goal().why() << agent_->err();
  EXPECT_GT(feedbacks_, 5);
  const Json state = Get("/api/state");
  // What it believes and where it is: goal_tolerance_m, and what AMCL is off.
  EXPECT_NEAR(state["truth"]["x"], kGoalX_m, 0.25);
  EXPECT_NEAR(state["truth"]["y"], kGoalY_m, 0.25);
  EXPECT_EQ(state["goal"]["state"], "succeeded");
  EXPECT_EQ(Get("/api/info")["simulated"], true);
  EXPECT_EQ(httplib::Client(page_).Get("/readyz")->status, 200);
  EXPECT_THAT(httplib::Client(page_).Get("/metrics")->body,
              AllOf(HasSubstr("treeline_agent_goals_total{outcome="
                              "\"succeeded\",cause=\"none\"} 1"),
                    HasSubstr("\ntreeline_agent_battery_charge_ratio 0.99")));
  agent_->Signal(SIGINT);
  EXPECT_EQ(agent_->WaitForExit(), 0) << agent_->err();
  EXPECT_THAT(agent_->err(), HasSubstr("event=stopped"));
  EXPECT_GT(std::filesystem::file_size(folder_ + "/run.tlog"), 100000U);
}

TEST_F(AgentRunTest, AGoalOverHttpCanBeCancelledPausedAndRepeated) {
  ASSERT_NO_FATAL_FAILURE(StartAgent({"--simulate", "cafe", "--people=false",
                                      "--camera-hz", "0", "--speed", "4"}));
  const std::string goal =
      absl::StrCat(R"({"poses":[{"x":)", kGoalX_m, R"(,"y":)", kGoalY_m,
                   R"(,"yaw":0,"level":0}]})");
  EXPECT_EQ(Post("/api/goal", goal), 200);
  EXPECT_EQ(Post("/api/pause", "{}"), 200);
  EXPECT_EQ(Post("/api/resume", "{}"), 200);
  EXPECT_EQ(Post("/api/cancel", "{}"), 200);
  EXPECT_EQ(Post("/api/goal", R"({"poses":[]})"), 400);
  // The next goal is taken.
  const v1::NavigateResponse last = DriveTo(kGoalX_m, kGoalY_m);
  EXPECT_EQ(last.goal().state(), v1::GOAL_STATE_SUCCEEDED)
      << last.goal().why() << agent_->err();
  EXPECT_EQ(Post("/api/sim/kidnap", R"({"place":"nowhere"})"), 404);
}

bool Stands(const Json& state) {
  return state["command"]["forward_mps"] == 0 &&
         state["command"]["yaw_rate_radps"] == 0;
}

TEST_F(AgentRunTest, IsDrivenByHandAndStandsWhenNobodySpeaks) {
  ASSERT_NO_FATAL_FAILURE(
      StartAgent({"--simulate", "cafe", "--people=false", "--camera-hz", "0"}));
  const Json before = StateWhere([](const Json& state) {
    return state["mode"] == "idle" && !state["truth"].is_null();
  });
  // On a busy machine commands come late, and some are refused.
  uint64_t sequence = 0;
  bool was_taken = false;
  StateWhere([&](const Json& state) {
    if (!Drive(0.3, ++sequence).ok()) return false;
    was_taken = was_taken || Drive(0.3, 1, "another").error_code() ==
                                 grpc::StatusCode::UNAVAILABLE;
    return was_taken && state["mode"] == "manual" &&
           state["command"]["forward_mps"] > 0.15;
  });
  EXPECT_EQ(Drive(0.3, 1).error_code(), grpc::StatusCode::ABORTED);
  const Json after = StateWhere([](const Json& state) {
    return state["mode"] == "idle" && Stands(state);
  });
  EXPECT_GT(after["truth"]["x"].get<double>(),
            before["truth"]["x"].get<double>() + 0.02);
}

TEST_F(AgentRunTest, ASimulatedRobotStandsWhereItIsToldToStart) {
  ASSERT_NO_FATAL_FAILURE(
      StartAgent({"--simulate", "cafe", "--people=false", "--camera-hz", "0",
                  "--start-at", "9,7.7,1.5"}));
  const Json state = Get("/api/state");
  EXPECT_NEAR(state["truth"]["x"], 9, 0.01);
  EXPECT_NEAR(state["truth"]["y"], 7.7, 0.01);
  EXPECT_NEAR(state["truth"]["yaw"], 1.5, 0.01);
  EXPECT_THAT(agent_->err(), HasSubstr("is ready after"));
  const ProgramResult inside =
      RunProgram({TREELINE_AGENT, "run", "--simulate", "cafe", "--people=false",
                  "--camera-hz", "0", "--listen", "", "--http-listen", "",
                  "--start-at=-30,0,0"});
  EXPECT_EQ(inside.exit_code, 1);
  EXPECT_THAT(inside.err, HasSubstr("--start-at"));
}

TEST_F(AgentRunTest, ThroughEmulatedDevicesToItsGoal) {
  Process robot({TREELINE_EMULATOR, "robot", "--world", "cafe", "--no-people",
                 "--laser", "tcp:0", "--rear-laser", "tcp:0", "--base", "pty"});
  const auto laser = robot.WaitForLine("laser at ");
  const auto base = robot.WaitForLine("base at ");
  const auto rear = robot.WaitForLine("rear laser at ");
  ASSERT_TRUE(laser.has_value() && base.has_value() && rear.has_value())
      << robot.err();
  const std::string hardware = folder_ + "/robot.yaml";
  ASSERT_TRUE(
      base::WriteNewFile(
          hardware,
          absl::StrCat(
              "laser: ", absl::StripPrefix(*laser, "laser at "),
              "\nrear_laser: ", absl::StripPrefix(*rear, "rear laser at "),
              "\nbase: ", absl::StripPrefix(*base, "base at "),
              // As small as a calibration finds them in good robots.
              "\nleft_wheel_scale: 1.002\nlaser_delay_s: 0.004\n"))
          .ok());
  ASSERT_NO_FATAL_FAILURE(WriteMap(folder_ + "/map"));
  ASSERT_NO_FATAL_FAILURE(StartAgent({"--map", folder_ + "/map", "--hardware",
                                      hardware, "--start-at", kStart}));
  const v1::NavigateResponse last = DriveTo(kGoalX_m, kGoalY_m);
  EXPECT_EQ(last.goal().state(), v1::GOAL_STATE_SUCCEEDED)
      << last.goal().why() << agent_->err();
  // The base tells volts alone.
  EXPECT_THAT(httplib::Client(page_).Get("/metrics")->body,
              AllOf(HasSubstr("\ntreeline_agent_battery_volts 7"),
                    Not(HasSubstr("\ntreeline_agent_battery_charge_ratio "))));
  agent_->Signal(SIGTERM);
  EXPECT_EQ(agent_->WaitForExit(), 0) << agent_->err();
  robot.Signal(SIGINT);
  robot.WaitForExit();
  EXPECT_THAT(robot.out(), Not(HasSubstr("collision")));
}

TEST_F(AgentRunTest, AFullDiskEndsTheRecordingAndNotTheDrive) {
  // A limit on file sizes fails the write as a full disk does.
  ASSERT_NO_FATAL_FAILURE(
      StartAgent({"--simulate", "cafe", "--people=false", "--camera-hz", "0",
                  "--speed", "4", "--record", folder_ + "/run.tlog"},
                 "trap '' XFSZ; ulimit -f 64"));
  const v1::NavigateResponse last = DriveTo(kGoalX_m, kGoalY_m);
  EXPECT_EQ(last.goal().state(), v1::GOAL_STATE_SUCCEEDED)
      << last.goal().why() << agent_->err();
  agent_->Signal(SIGINT);
  agent_->WaitForExit();
  EXPECT_THAT(agent_->err(), HasSubstr("the recording ends"));
  EXPECT_THAT(agent_->err(), HasSubstr("run.tlog"));
  EXPECT_THAT(agent_->err(), HasSubstr("File too large"));
}

TEST_F(AgentRunTest, AMapWithoutFreeGroundIsNamed) {
  const std::string map = folder_ + "/map";
  ASSERT_NO_FATAL_FAILURE(WriteMap(map));
  const std::string picture =
      map + "/" + map_bundle::kBundleLevels + "/level-0.pgm";
  auto pixels = base::ReadFile(picture, size_t{1} << 26);
  ASSERT_TRUE(pixels.ok()) << pixels.status();
  // All that is free is occupied: 254 is free, 0 is not.
  std::ranges::replace(*pixels, static_cast<char>(254), '\0');
  std::filesystem::remove(picture);
  ASSERT_TRUE(base::WriteNewFile(picture, *pixels).ok());
  const ProgramResult result =
      RunProgram({TREELINE_AGENT, "run", "--map", map, "--simulate", "cafe",
                  "--listen", "127.0.0.1:0", "--http-listen", "127.0.0.1:0"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("no free ground"));
  EXPECT_THAT(result.err, HasSubstr(map));
}

TEST_F(AgentRunTest, ATypoInTheConfigurationIsNamed) {
  const std::string config = folder_ + "/agent.yaml";
  ASSERT_TRUE(
      base::WriteNewFile(config, "simulate: cafe\nmax_foward_mps: 0.4\n").ok());
  const ProgramResult result =
      RunProgram({TREELINE_AGENT, "run", "--config", config});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("agent.yaml:2"));
  EXPECT_THAT(result.err, HasSubstr("max_forward_mps"));
}

TEST_F(AgentRunTest, WithoutARobotItSaysWhichThereAre) {
  const ProgramResult result = RunProgram({TREELINE_AGENT, "run"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err,
              HasSubstr("--simulate WORLD, --hardware FILE and --ros2 FILE"));
}

}  // namespace
}  // namespace treeline

// treeline-agent run as people run it: a robot in simulated time, and one whose
// laser and base are emulated byte for byte, driven through gRPC and HTTP.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <signal.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "tests/integration/process.h"
#include "treeline/v1/navigation.grpc.pb.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

// The café: from its tour's first corner to this place no door is in the way.
constexpr double kGoalX_m = TREELINE_AGENT_GOAL_X;
constexpr double kGoalY_m = TREELINE_AGENT_GOAL_Y;

class AgentRunTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = testing::TempDir() + "/agent-XXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Starts the agent on free ports and waits until it drives.
  void StartAgent(const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {TREELINE_AGENT,  "run",
                                        "--listen",      "127.0.0.1:0",
                                        "--http-listen", "127.0.0.1:0"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    agent_ = std::make_unique<Process>(command);
    const auto grpc = agent_->WaitForLine("grpc on ");
    ASSERT_TRUE(grpc.has_value()) << agent_->err();
    const auto page = agent_->WaitForLine("page on ");
    ASSERT_TRUE(page.has_value()) << agent_->err();
    ASSERT_TRUE(agent_->WaitForLine("driving").has_value()) << agent_->err();
    grpc_ = std::string(absl::StripPrefix(*grpc, "grpc on "));
    page_ = std::string(absl::StripPrefix(*page, "page on "));
    page_.pop_back();
    stub_ = v1::NavigationService::NewStub(
        grpc::CreateChannel(grpc_, grpc::InsecureChannelCredentials()));
  }

  // Drives there; the last that is heard of it.
  v1::NavigateResponse DriveTo(double x_m, double y_m) {
    v1::NavigateRequest request;
    v1::LevelPose& pose = *request.add_poses();
    pose.set_x_m(x_m);
    pose.set_y_m(y_m);
    grpc::ClientContext context;
    const auto stream = stub_->Navigate(&context, request);
    v1::NavigateResponse feedback;
    while (stream->Read(&feedback)) ++feedbacks_;
    const grpc::Status status = stream->Finish();
    EXPECT_TRUE(status.ok()) << status.error_message() << agent_->err();
    return feedback;
  }

  Json Get(const std::string& path) const {
    const auto answer = httplib::Client(page_).Get(path);
    if (!answer || answer->status != 200) {
      ADD_FAILURE() << path << " " << (answer ? answer->body : "no answer");
      return nullptr;
    }
    return Json::parse(answer->body);
  }
  int Post(const std::string& path, const std::string& body) const {
    const auto answer = httplib::Client(page_).Post(path, {{"X-Treeline", "1"}},
                                                    body, "application/json");
    return answer ? answer->status : -1;
  }

  std::string folder_;
  std::string grpc_;
  std::string page_;
  int feedbacks_ = 0;
  std::unique_ptr<Process> agent_;
  std::unique_ptr<v1::NavigationService::Stub> stub_;
};

TEST_F(AgentRunTest, ASimulatedRobotDrivesToItsGoalAndStopsOnInterrupt) {
  StartAgent({"--simulate", "cafe", "--people", "false", "--camera-hz", "0",
              "--speed", "4", "--record", folder_ + "/run.tlog"});
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
              HasSubstr("treeline_agent_goals_total{outcome=\"succeeded\","
                        "cause=\"none\"} 1"));
  agent_->Signal(SIGINT);
  EXPECT_EQ(agent_->WaitForExit(), 0) << agent_->err();
  EXPECT_THAT(agent_->err(), HasSubstr("event=stopped"));
  EXPECT_GT(std::filesystem::file_size(folder_ + "/run.tlog"), 100000U);
}

TEST_F(AgentRunTest, AGoalOverHttpCanBeCancelledPausedAndRepeated) {
  StartAgent({"--simulate", "cafe", "--people", "false", "--camera-hz", "0",
              "--speed", "4"});
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

TEST_F(AgentRunTest, ThroughEmulatedDevicesToItsGoal) {
  Process robot({TREELINE_EMULATOR, "robot", "--world", "cafe", "--no-people",
                 "--laser", "tcp:0", "--base", "pty"});
  const auto laser = robot.WaitForLine("laser at ");
  const auto base = robot.WaitForLine("base at ");
  ASSERT_TRUE(laser.has_value() && base.has_value()) << robot.err();
  const std::string hardware = folder_ + "/robot.yaml";
  ASSERT_TRUE(
      WriteNewFile(
          hardware,
          absl::StrCat("laser: ", absl::StripPrefix(*laser, "laser at "),
                       "\nbase: ", absl::StripPrefix(*base, "base at "), "\n"))
          .ok());
  const ProgramResult map =
      RunProgram({TREELINE_AGENT, "simulate", "--world", "cafe", "--no-people",
                  "--drive", "tour", "--camera-hz", "4", "--record",
                  folder_ + "/drive.tlog", "--quiet"});
  ASSERT_EQ(map.exit_code, 0) << map.err;
  const ProgramResult bundle =
      RunProgram({TREELINE_AGENT, "map", "--log", folder_ + "/drive.tlog",
                  "--output", folder_ + "/map", "--quiet"});
  ASSERT_EQ(bundle.exit_code, 0) << bundle.err;
  StartAgent({"--map", folder_ + "/map", "--hardware", hardware, "--start-at",
              TREELINE_AGENT_START});
  const v1::NavigateResponse last = DriveTo(kGoalX_m, kGoalY_m);
  EXPECT_EQ(last.goal().state(), v1::GOAL_STATE_SUCCEEDED)
      << last.goal().why() << agent_->err();
  agent_->Signal(SIGTERM);
  EXPECT_EQ(agent_->WaitForExit(), 0) << agent_->err();
  robot.Signal(SIGINT);
  robot.WaitForExit();
  EXPECT_THAT(robot.out(), ::testing::Not(HasSubstr("collision")));
}

TEST_F(AgentRunTest, ATypoInTheConfigurationIsNamed) {
  const std::string config = folder_ + "/agent.yaml";
  ASSERT_TRUE(
      WriteNewFile(config, "simulate: cafe\nmax_foward_mps: 0.4\n").ok());
  const ProgramResult result =
      RunProgram({TREELINE_AGENT, "run", "--config", config});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("agent.yaml:2"));
  EXPECT_THAT(result.err, HasSubstr("max_forward_mps"));
}

TEST_F(AgentRunTest, WithoutARobotItSaysWhichThereAre) {
  const ProgramResult result = RunProgram({TREELINE_AGENT, "run"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--simulate WORLD or --hardware FILE"));
}

}  // namespace
}  // namespace treeline

// treeline-agent run as people run it: a robot in simulated time, and one whose
// laser and base are emulated byte for byte, driven through gRPC and HTTP.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <signal.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "common/base/file.h"
#include "nav_agent/app/run/agent_robot.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/traversability/level_files.h"
#include "tests/integration/process.h"
#include "treeline/v1/navigation.grpc.pb.h"

namespace treeline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

// The cafe: where its tour begins, and a place at the other end of its
// counter, 7.4 m away.
constexpr char kStart[] = "1.6,7.9,0";
constexpr double kGoalX_m = 9.0;
constexpr double kGoalY_m = 7.7;

class AgentRunTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = testing::TempDir() + "/agent-XXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Starts the agent on free ports and waits until it drives.
  void StartAgent(const std::vector<std::string>& arguments,
                  const std::string& shell_before = "") {
    std::vector<std::string> command = {TREELINE_AGENT,  "run",
                                        "--listen",      "127.0.0.1:0",
                                        "--http-listen", "127.0.0.1:0"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    if (!shell_before.empty()) {
      command.insert(command.begin(),
                     {"/bin/bash", "-c", shell_before + "; exec \"$@\"", "sh"});
    }
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

  // A bundle of the cafe's perfect map, as mapping would leave it.
  static void WriteMap(const std::string& folder) {
    const auto map = run_app::MapOfWorld("cafe");
    ASSERT_TRUE(map.ok()) << map.status();
    ASSERT_TRUE(map_bundle::BeginMapBundle(folder, /*overwrite=*/false).ok());
    const std::string octomap = folder + "/" + map_bundle::kBundleOctomap;
    ASSERT_TRUE(octree::WriteOctree(map->voxels, octomap).ok());
    // A file ends where what is known ends, the world's voxels with the world.
    const auto voxels = octree::ReadOctree(octomap);
    ASSERT_TRUE(voxels.ok()) << voxels.status();
    const auto levels = traversability::ExtractTraversableMap(*voxels);
    ASSERT_TRUE(levels.ok()) << levels.status();
    map_bundle::MapBundleManifest manifest;
    manifest.name = "cafe";
    manifest.levels = static_cast<int>(levels->levels.size());
    manifest.resolution_m = voxels->resolution_m();
    manifest.poses = 1;
    const std::vector<dataset::TimedPose> trajectory = {{5, {}}};
    ASSERT_TRUE(traversability::WriteTraversableMap(
                    *levels, manifest.traversability.max_slope_rad,
                    folder + "/" + map_bundle::kBundleLevels)
                    .ok());
    ASSERT_TRUE(map_bundle::WriteBundleTrajectory(folder, trajectory).ok());
    ASSERT_TRUE(map_bundle::FinishMapBundle(folder, manifest).ok());
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

  // Waits for the first step: 503 says that there was none.
  Json Get(const std::string& path) const {
    auto answer = httplib::Client(page_).Get(path);
    for (int i = 0; i < 600 && answer && answer->status == 503; ++i) {
      absl::SleepFor(absl::Milliseconds(100));
      answer = httplib::Client(page_).Get(path);
    }
    if (!answer || answer->status != 200) {
      ADD_FAILURE() << path << " " << (answer ? answer->body : "no answer");
      return nullptr;
    }
    return Json::parse(answer->body);
  }
  // The first state that `holds`; null if there is none for a minute.
  Json StateWhere(const std::function<bool(const Json&)>& holds) const {
    for (int i = 0; i < 1200; ++i) {
      Json state = Get("/api/state");
      if (state.is_null() || holds(state)) return state;
      absl::SleepFor(absl::Milliseconds(50));
    }
    ADD_FAILURE() << "the state is still " << Get("/api/state");
    return nullptr;
  }
  grpc::Status Stop(const std::string& why, v1::StopResponse& response) {
    v1::StopRequest request;
    request.set_why(why);
    grpc::ClientContext context;
    return stub_->Stop(&context, request, &response);
  }
  grpc::Status Release() {
    grpc::ClientContext context;
    v1::ReleaseResponse response;
    return stub_->Release(&context, {}, &response);
  }
  grpc::Status Drive(double forward_mps, uint64_t sequence,
                     const std::string& driver = "test") {
    v1::DriveRequest request;
    request.set_forward_mps(forward_mps);
    request.set_driver(driver);
    request.set_sequence(sequence);
    grpc::ClientContext context;
    v1::DriveResponse response;
    return stub_->Drive(&context, request, &response);
  }
  grpc::Status Navigate(double x_m, double y_m) {
    v1::NavigateRequest request;
    request.add_poses()->set_x_m(x_m);
    request.mutable_poses(0)->set_y_m(y_m);
    request.set_keep_when_call_ends(true);
    grpc::ClientContext context;
    const auto stream = stub_->Navigate(&context, request);
    v1::NavigateResponse first;
    if (stream->Read(&first)) context.TryCancel();
    return stream->Finish();
  }
  // A command of the program's own that talks to the agent: what it printed.
  std::string Ask(std::vector<std::string> command, int wanted_exit = 0) {
    command.insert(command.begin(), TREELINE_AGENT);
    command.insert(command.end(), {"--agent", grpc_});
    const ProgramResult result = RunProgram(command);
    EXPECT_EQ(result.exit_code, wanted_exit) << result.err;
    return result.out + result.err;
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

TEST_F(AgentRunTest, AStopHoldsOverARestartUntilItIsReleased) {
  const std::vector<std::string> arguments = {
      "--simulate", "cafe",        "--people=false",  "--camera-hz",
      "0",          "--state-dir", folder_ + "/state"};
  ASSERT_NO_FATAL_FAILURE(StartAgent(arguments));
  EXPECT_EQ(Get("/api/state")["stop"], nullptr);
  EXPECT_EQ(Navigate(kGoalX_m, kGoalY_m).error_code(),
            grpc::StatusCode::CANCELLED);
  StateWhere(
      [](const Json& state) { return state["command"]["forward_mps"] > 0.1; });
  v1::StopResponse stopped;
  ASSERT_TRUE(Stop("a child", stopped).ok());
  EXPECT_TRUE(stopped.survives_restart()) << stopped.warning();
  const Json state =
      StateWhere([](const Json& now) { return now["mode"] == "stopped"; });
  EXPECT_TRUE(Stands(state)) << state;
  EXPECT_EQ(state["stop"]["why"], "a child");
  EXPECT_EQ(state["goal"]["state"], "cancelled");
  EXPECT_EQ(state["goal"]["cause"], "stopped");
  const grpc::Status refused = Navigate(kGoalX_m, kGoalY_m);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(refused.error_message(), HasSubstr("a child"));
  EXPECT_EQ(Drive(0.2, 1).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  agent_->Signal(SIGKILL);
  agent_->WaitForExit();

  std::vector<std::string> again = arguments;
  again.insert(again.end(), {"--goal", "9,7.7,0"});
  ASSERT_NO_FATAL_FAILURE(StartAgent(again));
  const Json later = Get("/api/state");
  EXPECT_EQ(later["mode"], "stopped") << later;
  EXPECT_EQ(later["stop"]["why"], "a child");
  EXPECT_EQ(later["goal"], nullptr);
  EXPECT_THAT(agent_->err(), HasSubstr("starts stopped"));
  EXPECT_THAT(agent_->err(), HasSubstr("the goal is refused"));
  ASSERT_TRUE(Release().ok());
  StateWhere([](const Json& now) { return now["mode"] == "idle"; });
  EXPECT_EQ(Post("/api/stop", "{}"), 200);
  EXPECT_EQ(Post("/api/release", "{}"), 200);
  agent_->Signal(SIGTERM);
  EXPECT_EQ(agent_->WaitForExit(), 0) << agent_->err();

  ASSERT_NO_FATAL_FAILURE(StartAgent(arguments));
  EXPECT_EQ(Get("/api/state")["stop"], nullptr);
}

// A polygon around the goal, drawn over the wire; and a mask across the cafe.
TEST_F(AgentRunTest, ZonesHoldOverARestart) {
  const std::vector<std::string> arguments = {"--simulate",
                                              "cafe",
                                              "--people=false",
                                              "--camera-hz",
                                              "0",
                                              "--speed",
                                              "4",
                                              "--state-dir",
                                              folder_ + "/state",
                                              "--zone-masks",
                                              folder_ + "/masks.yaml"};
  // Black in one of 4 x 1 pixels of 2 m.
  ASSERT_TRUE(
      base::WriteNewFile(folder_ + "/mask.pgm", "P2 4 1 255\n254 254 254 0\n")
          .ok());
  ASSERT_TRUE(base::WriteNewFile(folder_ + "/mask.yaml",
                                 "image: mask.pgm\nresolution: 2\n"
                                 "origin: [1, 1, 0]\n")
                  .ok());
  ASSERT_TRUE(base::WriteNewFile(folder_ + "/masks.yaml",
                                 "masks:\n  - file: mask.yaml\n"
                                 "    filter: keep-out\n")
                  .ok());
  ASSERT_NO_FATAL_FAILURE(StartAgent(arguments));
  v1::PutZonesRequest put;
  v1::Zone& zone = *put.add_zones();
  zone.set_name("counter");
  zone.set_kind(v1::ZONE_KIND_KEEP_OUT);
  for (const auto& [dx, dy] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    v1::ZoneCorner& corner = *zone.add_corners();
    corner.set_x_m(kGoalX_m + dx);
    corner.set_y_m(kGoalY_m + dy);
  }
  v1::PutZonesResponse answer;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(stub_->PutZones(&context, put, &answer).ok());
  }
  EXPECT_TRUE(answer.survives_restart()) << answer.warning();
  const auto refused = [this] {
    const grpc::Status status = Navigate(kGoalX_m, kGoalY_m);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
    EXPECT_THAT(status.error_message(), HasSubstr("keep-out zone 'counter'"));
  };
  refused();
  agent_->Signal(SIGKILL);
  agent_->WaitForExit();

  ASSERT_NO_FATAL_FAILURE(StartAgent(arguments));
  refused();
  EXPECT_THAT(Ask({"zones", "list"}),
              AllOf(HasSubstr("counter: keep-out, level 0, 4 corners\n"),
                    HasSubstr("a mask file\n")));
  const std::string drawn = folder_ + "/zones.yaml";
  ASSERT_TRUE(base::WriteNewFile(drawn, Ask({"zones", "export"})).ok());
  Ask({"zones", "delete", "counter"});
  Ask({"zones", "delete", "counter"}, 1);
  EXPECT_THAT(Ask({"zones", "save", drawn}), HasSubstr("zones drawn: 1"));
  v1::GetZonesResponse found;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(stub_->GetZones(&context, {}, &found).ok());
  }
  ASSERT_EQ(found.zones_size(), 1);
  EXPECT_EQ(found.zones(0).name(), "counter");
  ASSERT_EQ(found.masks_size(), 1);
  EXPECT_GT(found.masks(0).runs_size(), 0);
  v1::RemoveZonesRequest remove;
  remove.add_names("counter");
  v1::RemoveZonesResponse removed;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(stub_->RemoveZones(&context, remove, &removed).ok());
  }
  const v1::NavigateResponse last = DriveTo(kGoalX_m, kGoalY_m);
  EXPECT_EQ(last.goal().state(), v1::GOAL_STATE_SUCCEEDED)
      << last.goal().why() << agent_->err();
}

TEST_F(AgentRunTest, ZonesThatCannotBeReadAreNoReasonToDriveWithoutThem) {
  std::filesystem::create_directories(folder_ + "/state");
  ASSERT_TRUE(base::WriteNewFile(folder_ + "/state/zones",
                                 "treeline-zones 1\nkeep-out 0 0")
                  .ok());
  Process agent({TREELINE_AGENT, "run", "--listen", "127.0.0.1:0",
                 "--http-listen", "", "--simulate", "cafe", "--camera-hz", "0",
                 "--state-dir", folder_ + "/state"});
  EXPECT_NE(agent.WaitForExit(), 0);
  EXPECT_THAT(agent.err(), HasSubstr(folder_ + "/state/zones"));
  EXPECT_THAT(agent.err(), HasSubstr("it does not drive without them"));
}

// Killed on its way to the second of two waypoints.
TEST_F(AgentRunTest, ARouteIsOfferedAfterARestartAndGoesOn) {
  const std::vector<std::string> arguments = {
      "--simulate", "cafe", "--people=false", "--camera-hz",     "0",
      "--speed",    "4",    "--state-dir",    folder_ + "/state"};
  const std::string file = folder_ + "/routes.yaml";
  ASSERT_TRUE(base::WriteNewFile(file,
                                 "routes:\n"
                                 "  - name: \"rounds\"\n"
                                 "    loop: true\n"
                                 "    waypoints:\n"
                                 "      - {x: 2.6, y: 7.7, wait: 5}\n")
                  .ok());
  ASSERT_NO_FATAL_FAILURE(StartAgent(arguments));
  EXPECT_THAT(Ask({"route", "save", file}), HasSubstr("routes kept: 1"));
  v1::RunRouteRequest run;
  v1::Route& route = *run.mutable_route();
  route.set_name("patrol");
  for (const double x_m : {2.6, kGoalX_m}) {
    v1::Waypoint& waypoint = *route.add_waypoints();
    waypoint.set_x_m(x_m);
    waypoint.set_y_m(kGoalY_m);
  }
  {
    grpc::ClientContext context;
    const auto stream = stub_->RunRoute(&context, run);
    v1::RunRouteResponse feedback;
    while (stream->Read(&feedback) && feedback.route().waypoint() == 0) {
    }
    EXPECT_EQ(feedback.route().waypoint(), 1) << feedback.ShortDebugString();
    EXPECT_TRUE(feedback.route().survives_restart());
    agent_->Signal(SIGKILL);
    agent_->WaitForExit();
  }

  ASSERT_NO_FATAL_FAILURE(StartAgent(arguments));
  StateWhere([](const Json& state) { return state["mode"] == "idle"; });
  EXPECT_THAT(Ask({"route", "list"}),
              AllOf(HasSubstr("rounds: 1 waypoint in a loop, waits 5 s\n"),
                    HasSubstr("offered: patrol\n")));
  EXPECT_EQ(Ask({"route", "export"}), *base::ReadFile(file));
  EXPECT_THAT(Ask({"route", "run", "nowhere"}, 1),
              HasSubstr("no route is called 'nowhere'; there are: 'rounds'"));
  Ask({"route", "resume"});
  const Json arrived = StateWhere([](const Json& state) {
    return !state["goal"].is_null() && state["goal"]["state"] == "succeeded";
  });
  ASSERT_FALSE(arrived.is_null()) << agent_->err();
  EXPECT_NEAR(arrived["truth"]["x"], kGoalX_m, 0.4);
  EXPECT_THAT(agent_->err(), HasSubstr("waits to be resumed"));
  EXPECT_THAT(
      httplib::Client(page_).Get("/metrics")->body,
      HasSubstr("treeline_agent_routes_total{outcome=\"succeeded\"} 1"));
  agent_->Signal(SIGTERM);
  EXPECT_EQ(agent_->WaitForExit(), 0) << agent_->err();
}

TEST_F(AgentRunTest, AStopFileThatIsNotUnderstoodIsAStop) {
  std::filesystem::create_directories(folder_ + "/state");
  ASSERT_TRUE(
      base::WriteNewFile(folder_ + "/state/stop", "treeline-stop 1\nrel").ok());
  ASSERT_NO_FATAL_FAILURE(
      StartAgent({"--simulate", "cafe", "--people=false", "--camera-hz", "0",
                  "--state-dir", folder_ + "/state"}));
  EXPECT_EQ(Get("/api/state")["mode"], "stopped");
  EXPECT_THAT(agent_->err(), HasSubstr("whether it was stopped is not known"));
  ASSERT_TRUE(Release().ok());
  StateWhere([](const Json& now) { return now["mode"] == "idle"; });
}

TEST_F(AgentRunTest, OnAFullDiskTheRobotStartsStopped) {
  // A limit on file sizes fails the write as a full disk does.
  ASSERT_NO_FATAL_FAILURE(
      StartAgent({"--simulate", "cafe", "--people=false", "--camera-hz", "0",
                  "--state-dir", folder_ + "/state"},
                 "trap '' XFSZ; ulimit -f 0"));
  EXPECT_EQ(Get("/api/state")["mode"], "stopped");
  EXPECT_THAT(agent_->err(), HasSubstr("no stop could be kept"));
  ASSERT_TRUE(Release().ok());
  StateWhere([](const Json& now) { return now["mode"] == "idle"; });
  v1::StopResponse stopped;
  ASSERT_TRUE(Stop("", stopped).ok());
  EXPECT_FALSE(stopped.survives_restart());
  EXPECT_NE(stopped.warning(), "");
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

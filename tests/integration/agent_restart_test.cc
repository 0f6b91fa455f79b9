// What a robot keeps over restarts: a stop, zones, the route it was on.
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

}  // namespace
}  // namespace treeline

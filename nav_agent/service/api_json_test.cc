#include "nav_agent/service/api_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "nav_agent/service/navigation_wire.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using Json = nlohmann::json;

AgentState FullState() {
  AgentState state;
  state.time_s = 12.34567;
  state.missed_deadlines = 2;
  behavior::NavigatorSnapshot& snapshot = state.snapshot;
  snapshot.mode = behavior::NavigatorMode::kSafeStop;
  snapshot.cause = core::NavigationCause::kLaserLost;
  snapshot.cause_text = "no scan for 0.4 s";
  snapshot.steps = 77;
  localization::TrackedPose pose;
  pose.pose = {.map_from_base = {{1.00004, 2}, 0.5}, .place = {1, 0.75}};
  // Its longer axis lies along x + y: 0.05 + 0.03.
  pose.covariance = {0.05, 0.03, 0, 0.03, 0.05, 0, 0, 0, 0.04};
  pose.in_doubt = true;
  pose.place_share = 0.5;
  pose.other_places = {
      {.pose = {.map_from_base = {{3, 4}, 0.25}, .place = {0, 0.5}},
       .share = 0.4}};
  snapshot.pose = pose;
  snapshot.goal.emplace();
  snapshot.goal->id = 3;
  snapshot.goal->state = behavior::GoalState::kActive;
  snapshot.goal->to_go_m = 4.5;
  snapshot.goal->driven_m = 1;
  snapshot.goal->replans = 1;
  snapshot.goal->recoveries = 2;
  state.goal_poses = {{.map_from_base = {{9, 8}, 0}, .place = {0, 0}}};
  snapshot.command = {.forward_mps = 0.25, .yaw_rate_radps = -0.5};
  core::RelocalizationAnswer fix;
  fix.localized = true;
  fix.confidence = 0.9;
  fix.inliers = 40;
  fix.samples = 50;
  fix.scene = "house";
  const geometry::Rigid3 map_from_base = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, 0.7}),
      .translation = {3, 4, 0}};
  fix.map_from_camera = map_from_base * core::RobotModel().base_from_camera;
  snapshot.fix = fix;
  snapshot.fix_verdict = "accepted";
  snapshot.path = {{.map_from_base = {{1, 2}, 0.1}, .place = {0, 0.5}}};
  snapshot.bubbles = {
      {.center_in_map = {1, 2}, .heading_rad = 0, .radius_m = 0.4}};
  snapshot.tree_edges = {{0, 0}, {1, 1}};
  snapshot.scan_in_map = {{5, 6}};
  snapshot.blockages = {{.center = {1, 1}, .radius_m = 0.2, .level = 1}};
  snapshot.costmap = {.origin_in_map = {-1, -2},
                      .resolution_m = 0.05,
                      .width = 3,
                      .height = 1,
                      .cells = {0, 1, 2},
                      .distance_m = {}};
  state.devices = {{"laser", "lost", "unplugged"}};
  state.true_map_from_base = map_from_base;
  state.obstacles = {{"box-1", {2, 3}}};
  return state;
}

TEST(ApiJson, InfoDescribesRobotAndLevels) {
  const Json json = Json::parse(InfoJson(InfoToProto(TestInfo())));
  EXPECT_EQ(json["version"], "1.2.3");
  EXPECT_EQ(json["robot"]["front_m"], core::RobotModel().front_m);
  EXPECT_EQ(json["map"]["name"], "house");
  ASSERT_EQ(json["map"]["levels"].size(), 2U);
  EXPECT_EQ(json["map"]["levels"][1],
            Json::parse(R"({"index":1,"width":8,"height":6,"resolution_m":0.5,
      "origin":[-1.0,-1.0,0.0],"min_height_m":1.0,"max_height_m":1.0})"));
  EXPECT_EQ(json["simulated"], true);
  EXPECT_EQ(json["world"], "cafe");
  EXPECT_EQ(json["places"], Json::parse(R"(["kitchen"])"));
  EXPECT_EQ(json["server"], "localhost:50051");
}

TEST(ApiJson, StateHasEveryField) {
  const Json json =
      Json::parse(StateJson(StateToProto(TestInfo(), FullState())));
  EXPECT_EQ(json["time_s"], 12.3457);
  EXPECT_EQ(json["mode"], "safe_stop");
  EXPECT_EQ(json["cause"], "laser_lost");
  EXPECT_EQ(json["cause_text"], "no scan for 0.4 s");
  EXPECT_NE(json["advice"], "");
  EXPECT_EQ(json["pose"], Json::parse(R"({"x":1.0,"y":2.0,"yaw":0.5,"level":1,
      "height_m":0.75,"std_m":0.2828,"std_rad":0.2,"in_doubt":true,
      "place_share":0.5,
      "other_places":[{"x":3.0,"y":4.0,"yaw":0.25,"level":0,"share":0.4}]})"));
  EXPECT_EQ(json["lost"]["state"], "localized");
  EXPECT_EQ(json["command"],
            Json::parse(R"({"forward_mps":0.25,"yaw_rate_radps":-0.5})"));
  EXPECT_EQ(json["goal"],
            Json::parse(R"({"id":3,"state":"active","cause":"none","why":"",
      "to_go_m":4.5,"driven_m":1.0,"replans":1,"recoveries":2,
      "poses":[{"x":9.0,"y":8.0,"yaw":0.0,"level":0}]})"));
  EXPECT_EQ(json["fix"]["verdict"], "accepted");
  // The robot's pose, not the camera's.
  EXPECT_EQ(json["fix"]["x"], 3.0);
  EXPECT_EQ(json["fix"]["yaw"], 0.7);
  EXPECT_EQ(json["devices"], Json::parse(R"([{"name":"laser","state":"lost",
      "cause":"unplugged"}])"));
  EXPECT_EQ(json["truth"],
            Json::parse(R"({"x":3.0,"y":4.0,"yaw":0.7,"height_m":0.0})"));
  EXPECT_EQ(json["missed_deadlines"], 2);
  EXPECT_EQ(json["steps"], 77);
}

TEST(ApiJson, WhatIsNotThereIsNull) {
  const Json json =
      Json::parse(StateJson(StateToProto(TestInfo(), AgentState())));
  for (const char* name : {"pose", "goal", "fix", "truth"}) {
    EXPECT_TRUE(json.contains(name) && json[name].is_null()) << name;
  }
  EXPECT_EQ(json["mode"], "idle");
  EXPECT_EQ(json["cause"], "none");
  EXPECT_EQ(json["advice"], "");
}

TEST(ApiJson, SceneHasEveryField) {
  const Json json = Json::parse(SceneJson(SceneToProto(FullState())));
  EXPECT_EQ(json["path"], Json::parse("[[1.0,2.0,0.5,0.1]]"));
  EXPECT_EQ(json["bubbles"], Json::parse("[[1.0,2.0,0.75,0.4]]"));
  EXPECT_EQ(json["tree"], Json::parse("[0.0,0.0,1.0,1.0]"));
  EXPECT_EQ(json["scan"], Json::parse("[5.0,6.0]"));
  EXPECT_EQ(json["blockages"], Json::parse("[[1.0,1.0,0.2,1]]"));
  EXPECT_EQ(json["costmap"], Json::parse(R"({"origin":[-1.0,-2.0],
      "resolution_m":0.05,"width":3,"height":1,"z":0.75,"cells":"AAEC"})"));
  EXPECT_EQ(json["obstacles"],
            Json::parse(R"([{"name":"box-1","x":2.0,"y":3.0}])"));
}

TEST(ApiJson, ShowsAtMost500ParticlesOfAllOfThem) {
  AgentState state;
  for (int i = 0; i < 2000; ++i) {
    state.snapshot.particles.push_back(
        {.map_from_base = {{static_cast<double>(i), 0}, 0}, .weight = 1});
  }
  const Json particles =
      Json::parse(SceneJson(SceneToProto(state)))["particles"];
  ASSERT_EQ(particles.size(), 1500U);
  EXPECT_EQ(particles[0], 0.0);
  EXPECT_EQ(particles[1497], 1996.0);
}

TEST(ApiJson, StaysJsonWhateverIsInIt) {
  AgentState state;
  state.time_s = std::numeric_limits<double>::quiet_NaN();
  state.snapshot.cause_text = "\xff\"\n<script>";
  state.snapshot.command.forward_mps = std::numeric_limits<double>::infinity();
  const std::string text = StateJson(StateToProto(TestInfo(), state));
  const Json json = Json::parse(text);
  EXPECT_TRUE(json["time_s"].is_null());
  EXPECT_TRUE(json["command"]["forward_mps"].is_null());
  EXPECT_EQ(json["cause_text"], "\xEF\xBF\xBD\"\n<script>");
  // One line: an event of a stream.
  EXPECT_EQ(text.find('\n'), std::string::npos);
}

TEST(ApiJson, ErrorsHaveACode) {
  EXPECT_EQ(ErrorJson(absl::InvalidArgumentError("no \"x\"")),
            R"({"error":{"code":"invalid_argument","message":"no \"x\""}})");
}

}  // namespace
}  // namespace treeline::agent_service

#include "nav_agent/service/api_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "nav_agent/service/navigation_wire.h"

namespace treeline::agent_service {
namespace {

using Json = nlohmann::ordered_json;

// To four digits after the point: short, and more than a picture shows.
Json Rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  constexpr double kDigits = 1e4;
  const double rounded = std::round(value * kDigits) / kDigits;
  // Not -0.
  return rounded == 0 ? 0.0 : rounded;
}

std::string Text(const Json& json) {
  return json.dump(-1, ' ', /*ensure_ascii=*/false,
                   Json::error_handler_t::replace);
}

Json PoseJson(const v1::LevelPose& pose) {
  return {{"x", Rounded(pose.x_m())},
          {"y", Rounded(pose.y_m())},
          {"yaw", Rounded(pose.yaw_rad())},
          {"level", pose.level()}};
}

Json TrackedJson(const v1::RobotState& state) {
  if (!state.has_map_from_base()) return nullptr;
  Json json = PoseJson(state.map_from_base());
  json["height_m"] = Rounded(state.map_from_base().height_m());
  // Of the position: the standard deviation of its longer axis.
  const double a = state.covariance(0);
  const double b = state.covariance(1);
  const double d = state.covariance(4);
  const double largest = (a + d) / 2 + std::sqrt((a - d) * (a - d) / 4 + b * b);
  json["std_m"] = Rounded(std::sqrt(std::max(0.0, largest)));
  json["std_rad"] = Rounded(std::sqrt(std::max(0.0, state.covariance(8))));
  json["in_doubt"] = state.in_doubt();
  json["place_share"] = Rounded(state.place_share());
  Json others = Json::array();
  for (const v1::PossiblePlace& other : state.other_places()) {
    Json place = PoseJson(other.map_from_base());
    place["share"] = Rounded(other.share());
    others.push_back(std::move(place));
  }
  json["other_places"] = std::move(others);
  return json;
}

Json GoalJson(const v1::RobotState& state) {
  if (!state.has_goal()) return nullptr;
  const v1::GoalStatus& goal = state.goal();
  Json json = {{"id", goal.id()},
               {"state", GoalStateName(FromProto(goal.state()))},
               {"cause", core::NavigationCauseName(FromProto(goal.cause()))},
               {"why", goal.why()},
               {"to_go_m", Rounded(goal.to_go_m())},
               {"driven_m", Rounded(goal.driven_m())},
               {"replans", goal.replans()},
               {"recoveries", goal.recoveries()},
               {"poses", Json::array()}};
  for (const v1::LevelPose& pose : state.goal_poses()) {
    json["poses"].push_back(PoseJson(pose));
  }
  return json;
}

Json FixJson(const v1::RobotState& state) {
  if (!state.has_fix()) return nullptr;
  const v1::RelocalizationFix& fix = state.fix();
  Json json = {{"localized", fix.localized()},
               {"confidence", Rounded(fix.confidence())},
               {"inliers", fix.inliers()},
               {"samples", fix.samples()},
               {"scene", fix.scene()},
               {"reason", fix.reason()},
               {"round_trip_s", Rounded(fix.round_trip_s())},
               {"verdict", fix.verdict()},
               {"x", nullptr},
               {"y", nullptr},
               {"yaw", nullptr}};
  if (fix.has_map_from_base()) {
    json["x"] = Rounded(fix.map_from_base().x_m());
    json["y"] = Rounded(fix.map_from_base().y_m());
    json["yaw"] = Rounded(fix.map_from_base().yaw_rad());
  }
  return json;
}

Json TruthJson(const v1::RobotState& state) {
  if (!state.has_true_map_from_base()) return nullptr;
  const v1::LevelPose& pose = state.true_map_from_base();
  return {{"x", Rounded(pose.x_m())},
          {"y", Rounded(pose.y_m())},
          {"yaw", Rounded(pose.yaw_rad())},
          {"height_m", Rounded(pose.height_m())}};
}

Json StopJson(const v1::RobotState& state) {
  if (!state.has_stop()) return nullptr;
  return {{"why", state.stop().why()},
          {"since_s", Rounded(state.stop().since_s())}};
}

Json CostmapJson(const v1::RobotScene& scene) {
  if (!scene.has_costmap()) return nullptr;
  const v1::CostmapWindow& costmap = scene.costmap();
  return {{"origin",
           {Rounded(costmap.origin_x_m()), Rounded(costmap.origin_y_m())}},
          {"resolution_m", Rounded(costmap.resolution_m())},
          {"width", costmap.width()},
          {"height", costmap.height()},
          {"z", Rounded(costmap.height_m())},
          {"cells", absl::Base64Escape(costmap.cells())}};
}

Json FlatJson(const google::protobuf::RepeatedField<float>& values) {
  Json flat = Json::array();
  for (const float value : values) flat.push_back(Rounded(value));
  return flat;
}

}  // namespace

const char* GoalStateName(behavior::GoalState state) {
  switch (state) {
    case behavior::GoalState::kAccepted:
      return "accepted";
    case behavior::GoalState::kActive:
      return "active";
    case behavior::GoalState::kSucceeded:
      return "succeeded";
    case behavior::GoalState::kFailed:
      return "failed";
    case behavior::GoalState::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

std::string InfoJson(const v1::GetInfoResponse& info) {
  Json levels = Json::array();
  for (const v1::MapLevel& level : info.levels()) {
    levels.push_back(
        {{"index", level.index()},
         {"width", level.width()},
         {"height", level.height()},
         {"resolution_m", level.resolution_m()},
         {"origin",
          {level.origin_x_m(), level.origin_y_m(), level.origin_yaw_rad()}},
         {"min_height_m", Rounded(level.min_height_m())},
         {"max_height_m", Rounded(level.max_height_m())}});
  }
  Json places = Json::array();
  for (const std::string& place : info.places()) places.push_back(place);
  return Text({{"version", info.version()},
               {"robot",
                {{"front_m", info.robot().front_m()},
                 {"rear_m", info.robot().rear_m()},
                 {"half_width_m", info.robot().half_width_m()}}},
               {"map", {{"name", info.map_name()}, {"levels", levels}}},
               {"simulated", info.simulated()},
               {"world", info.world()},
               {"places", places},
               {"server", info.server()}});
}

std::string StateJson(const v1::RobotState& state) {
  Json devices = Json::array();
  for (const v1::DeviceStatus& device : state.devices()) {
    devices.push_back({{"name", device.name()},
                       {"state", device.state()},
                       {"cause", device.cause()}});
  }
  return Text({{"time_s", Rounded(state.time_s())},
               {"mode", behavior::NavigatorModeName(FromProto(state.mode()))},
               {"cause", core::NavigationCauseName(FromProto(state.cause()))},
               {"cause_text", state.cause_text()},
               {"advice", state.advice()},
               {"pose", TrackedJson(state)},
               {"lost",
                {{"probability", Rounded(state.lost_probability())},
                 {"state", state.lost_state()},
                 {"reason", state.lost_reason()}}},
               {"command",
                {{"forward_mps", Rounded(state.forward_mps())},
                 {"yaw_rate_radps", Rounded(state.yaw_rate_radps())}}},
               {"goal", GoalJson(state)},
               {"fix", FixJson(state)},
               {"devices", devices},
               {"truth", TruthJson(state)},
               {"stop", StopJson(state)},
               {"missed_deadlines", state.missed_deadlines()},
               {"steps", state.steps()}});
}

std::string WarnedJson(const absl::Status& warning) {
  if (warning.ok()) return Text({{"ok", true}});
  return Text({{"ok", true}, {"warning", std::string(warning.message())}});
}

std::string SceneJson(const v1::RobotScene& scene) {
  Json path = Json::array();
  for (const v1::LevelPose& pose : scene.path()) {
    path.push_back({Rounded(pose.x_m()), Rounded(pose.y_m()),
                    Rounded(pose.height_m()), Rounded(pose.yaw_rad())});
  }
  Json bubbles = Json::array();
  for (const v1::GroundCircle& bubble : scene.bubbles()) {
    bubbles.push_back({Rounded(bubble.x_m()), Rounded(bubble.y_m()),
                       Rounded(bubble.height_m()), Rounded(bubble.radius_m())});
  }
  Json blockages = Json::array();
  for (const v1::GroundCircle& blockage : scene.blockages()) {
    blockages.push_back({Rounded(blockage.x_m()), Rounded(blockage.y_m()),
                         Rounded(blockage.radius_m()), blockage.level()});
  }
  Json obstacles = Json::array();
  for (const v1::PlacedObstacle& obstacle : scene.obstacles()) {
    obstacles.push_back({{"name", obstacle.name()},
                         {"x", Rounded(obstacle.x_m())},
                         {"y", Rounded(obstacle.y_m())}});
  }
  return Text({{"path", path},
               {"bubbles", bubbles},
               {"tree", FlatJson(scene.tree_edges_m())},
               {"scan", FlatJson(scene.scan_m())},
               {"particles", FlatJson(scene.particles())},
               {"blockages", blockages},
               {"costmap", CostmapJson(scene)},
               {"obstacles", obstacles}});
}

std::string EventJson(const v1::RobotEvent& event) {
  return Text({{"number", event.number()},
               {"time_s", Rounded(event.time_s())},
               {"kind", event.kind()},
               {"text", event.text()}});
}

std::string CodeText(absl::StatusCode code) {
  return absl::AsciiStrToLower(absl::StatusCodeToString(code));
}

std::string ErrorJson(const absl::Status& status) {
  return ErrorJson(CodeText(status.code()), std::string(status.message()));
}

std::string ErrorJson(const std::string& code, const std::string& message) {
  return Text({{"error", {{"code", code}, {"message", message}}}});
}

}  // namespace treeline::agent_service

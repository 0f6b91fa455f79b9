#include "nav_agent/service/api_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"

namespace treeline::agent_service {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMostParticles = 500;

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

Json PoseJson(const core::LevelPose& pose) {
  return {{"x", Rounded(pose.map_from_base.translation.x)},
          {"y", Rounded(pose.map_from_base.translation.y)},
          {"yaw", Rounded(pose.map_from_base.yaw_rad)},
          {"level", pose.place.level}};
}

// Seen from above: where a transform of space takes the x axis.
double YawOf(const geometry::Rigid3& map_from_base) {
  const geometry::Vec3 ahead = map_from_base.rotation * geometry::Vec3{1, 0, 0};
  return std::atan2(ahead.y, ahead.x);
}

Json TrackedJson(const std::optional<localization::TrackedPose>& tracked) {
  if (!tracked.has_value()) return nullptr;
  Json json = PoseJson(tracked->pose);
  json["height_m"] = Rounded(tracked->pose.place.height_m);
  const auto& covariance = tracked->covariance;
  // Of the position: the standard deviation of its longer axis.
  const double a = covariance[0];
  const double b = covariance[1];
  const double d = covariance[4];
  const double largest = (a + d) / 2 + std::sqrt((a - d) * (a - d) / 4 + b * b);
  json["std_m"] = Rounded(std::sqrt(std::max(0.0, largest)));
  json["std_rad"] = Rounded(std::sqrt(std::max(0.0, covariance[8])));
  return json;
}

Json GoalJson(const std::optional<behavior::GoalStatus>& goal,
              const std::vector<core::LevelPose>& poses) {
  if (!goal.has_value()) return nullptr;
  Json json = {{"id", goal->id},
               {"state", GoalStateName(goal->state)},
               {"cause", core::NavigationCauseName(goal->cause)},
               {"why", goal->why},
               {"to_go_m", Rounded(goal->to_go_m)},
               {"driven_m", Rounded(goal->driven_m)},
               {"replans", goal->replans},
               {"recoveries", goal->recoveries},
               {"poses", Json::array()}};
  for (const core::LevelPose& pose : poses)
    json["poses"].push_back(PoseJson(pose));
  return json;
}

Json FixJson(const AgentInfo& info,
             const behavior::NavigatorSnapshot& snapshot) {
  if (!snapshot.fix.has_value()) return nullptr;
  const core::RelocalizationAnswer& fix = *snapshot.fix;
  Json json = {{"localized", fix.localized},
               {"confidence", Rounded(fix.confidence)},
               {"inliers", fix.inliers},
               {"samples", fix.samples},
               {"scene", fix.scene},
               {"reason", fix.reason},
               {"round_trip_s", Rounded(fix.round_trip_s)},
               {"verdict", snapshot.fix_verdict},
               {"x", nullptr},
               {"y", nullptr},
               {"yaw", nullptr}};
  if (fix.localized) {
    const geometry::Rigid3 map_from_base =
        fix.map_from_camera * info.robot.base_from_camera.Inverse();
    json["x"] = Rounded(map_from_base.translation.x);
    json["y"] = Rounded(map_from_base.translation.y);
    json["yaw"] = Rounded(YawOf(map_from_base));
  }
  return json;
}

Json CostmapJson(const control::CostmapView& costmap, double height_m) {
  const auto cells =
      static_cast<size_t>(costmap.width) * static_cast<size_t>(costmap.height);
  if (costmap.cells.empty() || costmap.cells.size() != cells) return nullptr;
  return {
      {"origin",
       {Rounded(costmap.origin_in_map.x), Rounded(costmap.origin_in_map.y)}},
      {"resolution_m", Rounded(costmap.resolution_m)},
      {"width", costmap.width},
      {"height", costmap.height},
      {"z", Rounded(height_m)},
      {"cells", absl::Base64Escape(absl::string_view(
                    reinterpret_cast<const char*>(costmap.cells.data()),
                    costmap.cells.size()))}};
}

Json FlatPoints(const std::vector<geometry::Vec2>& points) {
  Json flat = Json::array();
  for (const geometry::Vec2& point : points) {
    flat.push_back(Rounded(point.x));
    flat.push_back(Rounded(point.y));
  }
  return flat;
}

Json ParticlesJson(const std::vector<localization::Particle>& particles) {
  Json flat = Json::array();
  const size_t count = std::min(particles.size(), kMostParticles);
  for (size_t i = 0; i < count; ++i) {
    // Evenly over all of them.
    const geometry::Rigid2& pose =
        particles[i * particles.size() / count].map_from_base;
    flat.push_back(Rounded(pose.translation.x));
    flat.push_back(Rounded(pose.translation.y));
    flat.push_back(Rounded(pose.yaw_rad));
  }
  return flat;
}

// From the middle of the lowest ground to that of the highest.
std::pair<double, double> HeightsOf(
    const traversability::TraversableLevel& level) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const float height : level.height_m) {
    if (std::isnan(height)) continue;
    lowest = std::min(lowest, static_cast<double>(height));
    highest = std::max(highest, static_cast<double>(height));
  }
  return {lowest, highest};
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

std::string InfoJson(const AgentInfo& info) {
  Json levels = Json::array();
  for (size_t i = 0; i < info.map->levels.levels.size(); ++i) {
    const traversability::TraversableLevel& level = info.map->levels.levels[i];
    const geometry::Rigid2& origin = level.grid.map_from_grid;
    const auto [lowest, highest] = HeightsOf(level);
    levels.push_back(
        {{"index", i},
         {"width", level.grid.width},
         {"height", level.grid.height},
         {"resolution_m", level.grid.resolution_m},
         {"origin",
          {origin.translation.x, origin.translation.y, origin.yaw_rad}},
         {"min_height_m", Rounded(lowest)},
         {"max_height_m", Rounded(highest)}});
  }
  return Text({{"version", info.version},
               {"robot",
                {{"front_m", info.robot.front_m},
                 {"rear_m", info.robot.rear_m},
                 {"half_width_m", info.robot.half_width_m}}},
               {"map", {{"name", info.map_name}, {"levels", levels}}},
               {"simulated", info.is_simulated},
               {"world", info.world},
               {"places", info.places},
               {"server", info.server}});
}

std::string StateJson(const AgentInfo& info, const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  const bool has_cause = snapshot.cause != core::NavigationCause::kNone;
  Json devices = Json::array();
  for (const DeviceReport& device : state.devices) {
    devices.push_back({{"name", device.name},
                       {"state", device.state},
                       {"cause", device.cause}});
  }
  Json truth = nullptr;
  if (state.true_map_from_base.has_value()) {
    const geometry::Vec3& at = state.true_map_from_base->translation;
    truth = {{"x", Rounded(at.x)},
             {"y", Rounded(at.y)},
             {"yaw", Rounded(YawOf(*state.true_map_from_base))},
             {"height_m", Rounded(at.z)}};
  }
  return Text(
      {{"time_s", Rounded(state.time_s)},
       {"mode", behavior::NavigatorModeName(snapshot.mode)},
       {"cause", core::NavigationCauseName(snapshot.cause)},
       {"cause_text", snapshot.cause_text},
       {"advice", has_cause ? core::NavigationCauseAdvice(snapshot.cause) : ""},
       {"pose", TrackedJson(snapshot.pose)},
       {"lost",
        {{"probability", Rounded(snapshot.verdict.probability)},
         {"state", localization::LostStateName(snapshot.verdict.state)},
         {"reason", localization::LostReasonName(snapshot.verdict.reason)}}},
       {"command",
        {{"forward_mps", Rounded(snapshot.command.forward_mps)},
         {"yaw_rate_radps", Rounded(snapshot.command.yaw_rate_radps)}}},
       {"goal", GoalJson(snapshot.goal, state.goal_poses)},
       {"fix", FixJson(info, snapshot)},
       {"devices", devices},
       {"truth", truth},
       {"missed_deadlines", state.missed_deadlines},
       {"steps", snapshot.steps}});
}

std::string SceneJson(const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  const double height_m =
      snapshot.pose.has_value() ? snapshot.pose->pose.place.height_m : 0;
  Json path = Json::array();
  for (const core::LevelPose& pose : snapshot.path) {
    path.push_back({Rounded(pose.map_from_base.translation.x),
                    Rounded(pose.map_from_base.translation.y),
                    Rounded(pose.place.height_m),
                    Rounded(pose.map_from_base.yaw_rad)});
  }
  Json bubbles = Json::array();
  for (const control::Bubble& bubble : snapshot.bubbles) {
    bubbles.push_back({Rounded(bubble.center_in_map.x),
                       Rounded(bubble.center_in_map.y), Rounded(height_m),
                       Rounded(bubble.radius_m)});
  }
  Json blockages = Json::array();
  for (const planning::Blockage& blockage : snapshot.blockages) {
    blockages.push_back({Rounded(blockage.center.x), Rounded(blockage.center.y),
                         Rounded(blockage.radius_m), blockage.level});
  }
  Json obstacles = Json::array();
  for (const ObstacleReport& obstacle : state.obstacles) {
    obstacles.push_back({{"name", obstacle.name},
                         {"x", Rounded(obstacle.center_in_map.x)},
                         {"y", Rounded(obstacle.center_in_map.y)}});
  }
  return Text({{"path", path},
               {"bubbles", bubbles},
               {"tree", FlatPoints(snapshot.tree_edges)},
               {"scan", FlatPoints(snapshot.scan_in_map)},
               {"particles", ParticlesJson(snapshot.particles)},
               {"blockages", blockages},
               {"costmap", CostmapJson(snapshot.costmap, height_m)},
               {"obstacles", obstacles}});
}

std::string EventJson(const AgentHub::Event& event) {
  return Text({{"number", event.number},
               {"time_s", Rounded(event.time_s)},
               {"kind", event.kind},
               {"text", event.text}});
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

#include "nav_agent/service/navigation_wire.h"

#include <algorithm>
#include <limits>

#include "common/base/clock.h"
#include "common/geometry/planar_pose.h"
#include "common/wire/geometry.h"
#include "nav_agent/service/docks_wire.h"
#include "nav_agent/service/routes_wire.h"
#include "nav_agent/service/utf8_text.h"

namespace treeline::agent_service {
namespace {

constexpr size_t kMaxParticles = 500;

v1::RelocalizationFix FixToProto(const AgentInfo& info,
                                 const behavior::NavigatorSnapshot& snapshot) {
  const core::RelocalizationAnswer& answer = *snapshot.fix;
  v1::RelocalizationFix proto;
  proto.set_localized(answer.localized);
  proto.set_verdict(Utf8(snapshot.fix_verdict));
  proto.set_confidence(answer.confidence);
  proto.set_inliers(answer.inliers);
  proto.set_samples(answer.samples);
  proto.set_scene(Utf8(answer.scene));
  proto.set_reason(Utf8(answer.reason));
  proto.set_round_trip_s(answer.round_trip_s);
  if (!answer.localized) return proto;
  *proto.mutable_map_from_camera() = ToProto(answer.map_from_camera);
  *proto.mutable_map_from_base() = PlanarToProto(
      answer.map_from_camera * info.robot.base_from_camera.Inverse());
  return proto;
}

v1::CostmapWindow CostmapToProto(const control::CostmapView& costmap,
                                 double height_m) {
  v1::CostmapWindow proto;
  proto.set_origin_x_m(costmap.origin_in_map.x);
  proto.set_origin_y_m(costmap.origin_in_map.y);
  proto.set_resolution_m(costmap.resolution_m);
  proto.set_width(costmap.width);
  proto.set_height(costmap.height);
  proto.set_height_m(height_m);
  proto.set_cells(costmap.cells.data(), costmap.cells.size());
  return proto;
}

bool HasCells(const control::CostmapView& costmap) {
  return !costmap.cells.empty() &&
         costmap.cells.size() == static_cast<size_t>(costmap.width) *
                                     static_cast<size_t>(costmap.height);
}

void AppendPoints(const std::vector<geometry::Vec2>& points,
                  google::protobuf::RepeatedField<float>& flat) {
  flat.Reserve(static_cast<int>(2 * points.size()));
  for (const geometry::Vec2& point : points) {
    flat.Add(static_cast<float>(point.x));
    flat.Add(static_cast<float>(point.y));
  }
}

void AppendParticles(const std::vector<localization::Particle>& particles,
                     google::protobuf::RepeatedField<float>& flat) {
  const size_t count = std::min(particles.size(), kMaxParticles);
  for (size_t i = 0; i < count; ++i) {
    // Evenly over all of them.
    const geometry::Rigid2& pose =
        particles[i * particles.size() / count].map_from_base;
    flat.Add(static_cast<float>(pose.translation.x));
    flat.Add(static_cast<float>(pose.translation.y));
    flat.Add(static_cast<float>(pose.yaw_rad));
  }
}

}  // namespace

RequestedPose FromProto(const v1::LevelPose& proto) {
  return {.x_m = proto.x_m(),
          .y_m = proto.y_m(),
          .yaw_rad = proto.yaw_rad(),
          .level = proto.level()};
}

std::vector<RequestedPose> FromProto(
    const google::protobuf::RepeatedPtrField<v1::LevelPose>& proto) {
  std::vector<RequestedPose> poses;
  poses.reserve(static_cast<size_t>(proto.size()));
  for (const v1::LevelPose& pose : proto) poses.push_back(FromProto(pose));
  return poses;
}

v1::LevelPose ToProto(const core::LevelPose& pose) {
  v1::LevelPose proto;
  proto.set_x_m(pose.map_from_base.translation.x);
  proto.set_y_m(pose.map_from_base.translation.y);
  proto.set_yaw_rad(pose.map_from_base.yaw_rad);
  proto.set_level(pose.place.level);
  proto.set_height_m(pose.place.height_m);
  return proto;
}

v1::LevelPose PlanarToProto(const geometry::Rigid3& map_from_base) {
  v1::LevelPose proto;
  proto.set_x_m(map_from_base.translation.x);
  proto.set_y_m(map_from_base.translation.y);
  proto.set_yaw_rad(geometry::Yaw_rad(map_from_base.rotation));
  proto.set_height_m(map_from_base.translation.z);
  return proto;
}

// Numbers of these protos are one higher: 0 is "unspecified" there.
v1::NavigatorMode ToProto(behavior::NavigatorMode mode) {
  return static_cast<v1::NavigatorMode>(static_cast<int>(mode) + 1);
}
behavior::NavigatorMode FromProto(v1::NavigatorMode proto) {
  return static_cast<behavior::NavigatorMode>(static_cast<int>(proto) - 1);
}
v1::GoalState ToProto(behavior::GoalState state) {
  return static_cast<v1::GoalState>(static_cast<int>(state) + 1);
}
behavior::GoalState FromProto(v1::GoalState proto) {
  return static_cast<behavior::GoalState>(static_cast<int>(proto) - 1);
}

v1::NavigationCause ToProto(core::NavigationCause cause) {
  return static_cast<v1::NavigationCause>(cause);
}
core::NavigationCause FromProto(v1::NavigationCause proto) {
  return static_cast<core::NavigationCause>(proto);
}

v1::GoalStatus ToProto(const behavior::GoalStatus& goal) {
  v1::GoalStatus proto;
  proto.set_id(goal.id);
  proto.set_state(ToProto(goal.state));
  proto.set_cause(ToProto(goal.cause));
  proto.set_why(Utf8(goal.why));
  proto.set_next_pose(static_cast<int32_t>(goal.next_pose));
  proto.set_to_go_m(goal.to_go_m);
  proto.set_driven_m(goal.driven_m);
  proto.set_replans(goal.replans);
  proto.set_recoveries(goal.recoveries);
  return proto;
}

v1::RobotState StateToProto(const AgentInfo& info, const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  v1::RobotState proto;
  proto.set_time_s(state.time_s);
  proto.set_mode(ToProto(snapshot.mode));
  proto.set_cause(ToProto(snapshot.cause));
  proto.set_cause_text(Utf8(snapshot.cause_text));
  if (snapshot.cause != core::NavigationCause::kNone) {
    proto.set_advice(core::NavigationCauseAdvice(snapshot.cause));
  }
  if (snapshot.pose.has_value()) {
    *proto.mutable_map_from_base() = ToProto(snapshot.pose->pose);
    proto.mutable_covariance()->Add(snapshot.pose->covariance.begin(),
                                    snapshot.pose->covariance.end());
    proto.set_in_doubt(snapshot.pose->in_doubt);
    proto.set_place_share(snapshot.pose->place_share);
    for (const localization::PossiblePlace& other :
         snapshot.pose->other_places) {
      v1::PossiblePlace& place = *proto.add_other_places();
      *place.mutable_map_from_base() = ToProto(other.pose);
      place.set_share(other.share);
    }
  }
  proto.set_lost_probability(snapshot.verdict.probability);
  proto.set_lost_state(localization::LostStateName(snapshot.verdict.state));
  proto.set_lost_reason(localization::LostReasonName(snapshot.verdict.reason));
  proto.set_forward_mps(snapshot.command.forward_mps);
  proto.set_yaw_rate_radps(snapshot.command.yaw_rate_radps);
  if (snapshot.goal.has_value())
    *proto.mutable_goal() = ToProto(*snapshot.goal);
  for (const core::LevelPose& pose : state.goal_poses) {
    *proto.add_goal_poses() = ToProto(pose);
  }
  for (const DeviceReport& device : state.devices) {
    v1::DeviceStatus& status = *proto.add_devices();
    status.set_name(Utf8(device.name));
    status.set_state(device.state);
    status.set_cause(Utf8(device.cause));
  }
  if (state.true_map_from_base.has_value()) {
    *proto.mutable_true_map_from_base() =
        PlanarToProto(*state.true_map_from_base);
  }
  proto.set_steps(snapshot.steps);
  proto.set_missed_deadlines(state.missed_deadlines);
  if (state.battery.has_value()) {
    v1::BatteryStatus& battery = *proto.mutable_battery();
    battery.set_voltage_v(state.battery->voltage_v);
    if (state.battery->charge.has_value()) {
      battery.set_charge(*state.battery->charge);
    }
    battery.set_charging(
        static_cast<v1::BatteryCharging>(state.battery->charging));
  }
  proto.set_zones_revision(state.zones_revision);
  if (state.route.has_value()) {
    *proto.mutable_route() = ToProto(*state.route, state.route_keeping);
  }
  proto.set_routes_revision(state.routes_revision);
  *proto.mutable_docking() = ToProto(state.docks);
  if (snapshot.stop.has_value()) {
    v1::OperatorStop& stop = *proto.mutable_stop();
    stop.set_why(Utf8(snapshot.stop->why));
    stop.set_since_s(state.time_s - base::SecondsBetween(snapshot.stop->since,
                                                         snapshot.stamp));
  }
  if (snapshot.fix.has_value()) {
    *proto.mutable_fix() = FixToProto(info, snapshot);
  }
  return proto;
}

v1::RobotEvent ToProto(const AgentHub::Event& event) {
  v1::RobotEvent proto;
  proto.set_number(event.number);
  proto.set_time_s(event.time_s);
  proto.set_kind(Utf8(event.kind));
  proto.set_text(Utf8(event.text));
  return proto;
}

v1::NavigateResponse FeedbackToProto(const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  v1::NavigateResponse proto;
  if (snapshot.goal.has_value())
    *proto.mutable_goal() = ToProto(*snapshot.goal);
  proto.set_mode(ToProto(snapshot.mode));
  if (snapshot.pose.has_value()) {
    *proto.mutable_map_from_base() = ToProto(snapshot.pose->pose);
  }
  proto.set_forward_mps(snapshot.command.forward_mps);
  proto.set_yaw_rate_radps(snapshot.command.yaw_rate_radps);
  return proto;
}

v1::RunRouteResponse RouteFeedbackToProto(const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  v1::RunRouteResponse proto;
  *proto.mutable_route() = ToProto(*state.route, state.route_keeping);
  if (snapshot.goal.has_value() && snapshot.goal->id == state.route->goal_id) {
    *proto.mutable_goal() = ToProto(*snapshot.goal);
  }
  proto.set_mode(ToProto(snapshot.mode));
  if (snapshot.pose.has_value()) {
    *proto.mutable_map_from_base() = ToProto(snapshot.pose->pose);
  }
  return proto;
}

v1::MapLevel ToProto(const traversability::TraversableLevel& level, int index) {
  const core::OccupancyGrid& grid = level.grid;
  v1::MapLevel proto;
  proto.set_index(index);
  proto.set_width(grid.width);
  proto.set_height(grid.height);
  proto.set_resolution_m(grid.resolution_m);
  proto.set_origin_x_m(grid.map_from_grid.translation.x);
  proto.set_origin_y_m(grid.map_from_grid.translation.y);
  proto.set_origin_yaw_rad(grid.map_from_grid.yaw_rad);
  float lowest = std::numeric_limits<float>::infinity();
  float highest = -lowest;
  for (const float height : level.height_m) {
    // Comparisons with NaN are false.
    if (height < lowest) lowest = height;
    if (height > highest) highest = height;
  }
  if (lowest <= highest) {
    proto.set_min_height_m(lowest);
    proto.set_max_height_m(highest);
  }
  proto.set_free_cells(
      std::count(grid.cells.begin(), grid.cells.end(), core::Occupancy::kFree));
  return proto;
}

v1::GetInfoResponse InfoToProto(const AgentInfo& info) {
  v1::GetInfoResponse proto;
  proto.set_version(info.version);
  v1::RobotFootprint& robot = *proto.mutable_robot();
  robot.set_front_m(info.robot.front_m);
  robot.set_rear_m(info.robot.rear_m);
  robot.set_half_width_m(info.robot.half_width_m);
  proto.set_map_name(Utf8(info.map_name));
  int index = 0;
  for (const traversability::TraversableLevel& level :
       info.map->levels.levels) {
    *proto.add_levels() = ToProto(level, index++);
  }
  proto.set_simulated(info.is_simulated);
  proto.set_world(Utf8(info.world));
  for (const std::string& place : info.places) proto.add_places(Utf8(place));
  proto.set_server(Utf8(info.server));
  return proto;
}

v1::RobotScene SceneToProto(const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  const double height_m =
      snapshot.pose.has_value() ? snapshot.pose->pose.place.height_m : 0;
  v1::RobotScene proto;
  for (const core::LevelPose& pose : snapshot.path) {
    *proto.add_path() = ToProto(pose);
  }
  for (const control::Bubble& bubble : snapshot.bubbles) {
    v1::GroundCircle& circle = *proto.add_bubbles();
    circle.set_x_m(bubble.center_in_map.x);
    circle.set_y_m(bubble.center_in_map.y);
    circle.set_radius_m(bubble.radius_m);
    circle.set_height_m(height_m);
  }
  AppendPoints(snapshot.tree_edges, *proto.mutable_tree_edges_m());
  AppendPoints(snapshot.scan_in_map, *proto.mutable_scan_m());
  AppendParticles(snapshot.particles, *proto.mutable_particles());
  for (const planning::Blockage& blockage : snapshot.blockages) {
    v1::GroundCircle& circle = *proto.add_blockages();
    circle.set_x_m(blockage.center.x);
    circle.set_y_m(blockage.center.y);
    circle.set_radius_m(blockage.radius_m);
    circle.set_level(blockage.level);
  }
  if (HasCells(snapshot.costmap)) {
    *proto.mutable_costmap() = CostmapToProto(snapshot.costmap, height_m);
  }
  for (const ObstacleReport& obstacle : state.obstacles) {
    v1::PlacedObstacle& placed = *proto.add_obstacles();
    placed.set_name(Utf8(obstacle.name));
    placed.set_x_m(obstacle.center_in_map.x);
    placed.set_y_m(obstacle.center_in_map.y);
  }
  return proto;
}

}  // namespace treeline::agent_service

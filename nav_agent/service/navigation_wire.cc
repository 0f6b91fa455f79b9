#include "nav_agent/service/navigation_wire.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/wire/geometry.h"

namespace treeline::agent_service {

PoseWish FromProto(const v1::LevelPose& proto) {
  return {.x_m = proto.x_m(),
          .y_m = proto.y_m(),
          .yaw_rad = proto.yaw_rad(),
          .level = proto.level()};
}

std::vector<PoseWish> FromProto(
    const google::protobuf::RepeatedPtrField<v1::LevelPose>& proto) {
  std::vector<PoseWish> poses;
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
  const geometry::Vec3 ahead = map_from_base.rotation * geometry::Vec3{1, 0, 0};
  v1::LevelPose proto;
  proto.set_x_m(map_from_base.translation.x);
  proto.set_y_m(map_from_base.translation.y);
  proto.set_yaw_rad(std::atan2(ahead.y, ahead.x));
  proto.set_height_m(map_from_base.translation.z);
  return proto;
}

v1::NavigatorMode ToProto(behavior::NavigatorMode mode) {
  // Numbers of the proto are one higher: 0 is "unspecified" there.
  return static_cast<v1::NavigatorMode>(static_cast<int>(mode) + 1);
}

v1::NavigationCause ToProto(core::NavigationCause cause) {
  return static_cast<v1::NavigationCause>(cause);
}

v1::GoalStatus ToProto(const behavior::GoalStatus& goal) {
  v1::GoalStatus proto;
  proto.set_id(goal.id);
  proto.set_state(static_cast<v1::GoalState>(static_cast<int>(goal.state) + 1));
  proto.set_cause(ToProto(goal.cause));
  proto.set_why(goal.why);
  proto.set_next_pose(static_cast<int32_t>(goal.next_pose));
  proto.set_to_go_m(goal.to_go_m);
  proto.set_driven_m(goal.driven_m);
  proto.set_replans(goal.replans);
  proto.set_recoveries(goal.recoveries);
  return proto;
}

v1::RobotState ToProto(const AgentState& state) {
  const behavior::NavigatorSnapshot& snapshot = state.snapshot;
  v1::RobotState proto;
  proto.set_time_s(state.time_s);
  proto.set_mode(ToProto(snapshot.mode));
  proto.set_cause(ToProto(snapshot.cause));
  proto.set_cause_text(snapshot.cause_text);
  if (snapshot.cause != core::NavigationCause::kNone) {
    proto.set_advice(core::NavigationCauseAdvice(snapshot.cause));
  }
  if (snapshot.pose.has_value()) {
    *proto.mutable_map_from_base() = ToProto(snapshot.pose->pose);
    proto.mutable_covariance()->Add(snapshot.pose->covariance.begin(),
                                    snapshot.pose->covariance.end());
  }
  proto.set_lost_probability(snapshot.verdict.probability);
  proto.set_lost_state(localization::LostStateName(snapshot.verdict.state));
  proto.set_lost_reason(localization::LostReasonName(snapshot.verdict.reason));
  proto.set_forward_mps(snapshot.command.forward_mps);
  proto.set_yaw_rate_radps(snapshot.command.yaw_rate_radps);
  if (snapshot.goal.has_value())
    *proto.mutable_goal() = ToProto(*snapshot.goal);
  for (const DeviceReport& device : state.devices) {
    v1::DeviceStatus& status = *proto.add_devices();
    status.set_name(device.name);
    status.set_state(device.state);
    status.set_cause(device.cause);
  }
  if (state.true_map_from_base.has_value()) {
    *proto.mutable_true_map_from_base() =
        PlanarToProto(*state.true_map_from_base);
  }
  proto.set_steps(snapshot.steps);
  proto.set_missed_deadlines(state.missed_deadlines);
  if (snapshot.fix.has_value()) {
    const core::RelocalizationAnswer& answer = *snapshot.fix;
    v1::RelocalizationFix& fix = *proto.mutable_fix();
    fix.set_localized(answer.localized);
    fix.set_verdict(snapshot.fix_verdict);
    fix.set_confidence(answer.confidence);
    fix.set_inliers(answer.inliers);
    fix.set_samples(answer.samples);
    fix.set_scene(answer.scene);
    fix.set_round_trip_s(answer.round_trip_s);
    if (answer.localized) {
      *fix.mutable_map_from_camera() = ToProto(answer.map_from_camera);
    }
  }
  return proto;
}

v1::RobotEvent ToProto(const AgentHub::Event& event) {
  v1::RobotEvent proto;
  proto.set_number(event.number);
  proto.set_time_s(event.time_s);
  proto.set_kind(event.kind);
  proto.set_text(event.text);
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

}  // namespace treeline::agent_service

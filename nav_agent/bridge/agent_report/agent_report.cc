#include "nav_agent/bridge/agent_report/agent_report.h"

#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/bridge/place_finder/place_report.h"
#include "nav_agent/service/api_json.h"

namespace treeline::agent_report {
namespace {

using messages::DiagnosticStatus;

geometry::Rigid3 OnGround(const core::LevelPose& pose) {
  const geometry::Rigid2& planar = pose.map_from_base;
  return {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, planar.yaw_rad}),
      .translation = {planar.translation.x, planar.translation.y,
                      pose.place.height_m}};
}

DiagnosticStatus NavigationStatus(const behavior::NavigatorSnapshot& robot) {
  DiagnosticStatus status;
  status.name = "treeline: navigation";
  status.message = behavior::NavigatorModeName(robot.mode);
  if (!robot.cause_text.empty()) {
    absl::StrAppend(&status.message, ": ", robot.cause_text);
  }
  switch (robot.mode) {
    case behavior::NavigatorMode::kSafeStop:
    case behavior::NavigatorMode::kNeedHelp:
      status.level = DiagnosticStatus::kError;
      break;
    case behavior::NavigatorMode::kStopped:
    case behavior::NavigatorMode::kLost:
    case behavior::NavigatorMode::kRelocalizing:
    case behavior::NavigatorMode::kRecovering:
      status.level = DiagnosticStatus::kWarn;
      break;
    default:
      status.level = DiagnosticStatus::kOk;
      break;
  }
  status.values = {
      {"cause", core::NavigationCauseName(robot.cause)},
      {"forward (m/s)", absl::StrFormat("%.3f", robot.command.forward_mps)},
      {"turn (rad/s)", absl::StrFormat("%.3f", robot.command.yaw_rate_radps)},
      {"steps", absl::StrCat(robot.steps)},
      {"missed deadlines", absl::StrCat(robot.missed_deadlines)}};
  return status;
}

DiagnosticStatus LocalizationStatus(const behavior::NavigatorSnapshot& robot) {
  DiagnosticStatus status;
  status.name = "treeline: localization";
  if (!robot.pose.has_value()) {
    status.level = DiagnosticStatus::kStale;
    status.message = "nobody has said where the robot is";
    return status;
  }
  place_finder::TellVerdict(robot.verdict, status);
  status.values.push_back(
      {"level", absl::StrCat(robot.pose->pose.place.level)});
  return status;
}

DiagnosticStatus GoalStatusOf(const behavior::GoalStatus& goal) {
  DiagnosticStatus status;
  status.name = "treeline: goal";
  status.message = agent_service::GoalStateName(goal.state);
  if (!goal.why.empty()) absl::StrAppend(&status.message, ": ", goal.why);
  status.level = goal.state == behavior::GoalState::kFailed
                     ? DiagnosticStatus::kError
                     : DiagnosticStatus::kOk;
  status.values = {{"id", absl::StrCat(goal.id)},
                   {"cause", core::NavigationCauseName(goal.cause)},
                   {"to go (m)", absl::StrFormat("%.2f", goal.to_go_m)},
                   {"driven (m)", absl::StrFormat("%.2f", goal.driven_m)},
                   {"recoveries", absl::StrCat(goal.recoveries)}};
  return status;
}

DiagnosticStatus TopicsStatus(const TopicFacts& topics) {
  DiagnosticStatus status;
  status.name = "treeline: topics";
  status.message = "messages come";
  if (!topics.is_clock_running) {
    status.level = DiagnosticStatus::kError;
    status.message = "nothing comes on /clock: time stands still";
  }
  status.values = {{"messages", absl::StrCat(topics.delivered)},
                   {"refused", absl::StrCat(topics.refused)},
                   {"clock jumps", absl::StrCat(topics.clock_jumps)},
                   {"odometry leaps", absl::StrCat(topics.odometry_leaps)}};
  return status;
}

DiagnosticStatus DeviceStatus(const agent_service::DeviceReport& device) {
  DiagnosticStatus status;
  status.name = absl::StrCat("treeline: ", device.name);
  status.message = device.cause.empty()
                       ? device.state
                       : absl::StrCat(device.state, ": ", device.cause);
  if (device.state == "lost") {
    status.level = DiagnosticStatus::kError;
  } else if (device.state != "running") {
    status.level = DiagnosticStatus::kStale;
  }
  return status;
}

}  // namespace

geometry::Rigid3 MapFromBase(const localization::TrackedPose& pose) {
  geometry::Rigid3 map_from_base = OnGround(pose.pose);
  map_from_base.rotation = map_from_base.rotation * pose.level_from_base;
  return map_from_base;
}

messages::PoseWithCovarianceStamped PlaceOf(
    const localization::TrackedPose& pose, const messages::Header& header) {
  messages::PoseWithCovarianceStamped place;
  place.header = header;
  place.pose.pose = conversions::PoseOf(MapFromBase(pose));
  // x, y and the rotation about z.
  constexpr std::array<size_t, 3> kAxes = {0, 1, 5};
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 3; ++column) {
      place.pose.covariance[6 * kAxes[row] + kAxes[column]] =
          pose.covariance[3 * row + column];
    }
  }
  return place;
}

messages::Path PathOf(const std::vector<core::LevelPose>& path,
                      const messages::Header& header) {
  messages::Path message;
  message.header = header;
  message.poses.reserve(path.size());
  for (const core::LevelPose& pose : path) {
    message.poses.push_back(
        {.header = header, .pose = conversions::PoseOf(OnGround(pose))});
  }
  return message;
}

messages::DiagnosticArray ReportOf(const agent_service::AgentState& state,
                                   const std::optional<TopicFacts>& topics,
                                   const messages::Time& stamp) {
  messages::DiagnosticArray report;
  report.header.stamp = stamp;
  report.status = {NavigationStatus(state.snapshot),
                   LocalizationStatus(state.snapshot)};
  if (state.snapshot.goal.has_value()) {
    report.status.push_back(GoalStatusOf(*state.snapshot.goal));
  }
  if (topics) report.status.push_back(TopicsStatus(*topics));
  for (const agent_service::DeviceReport& device : state.devices) {
    report.status.push_back(DeviceStatus(device));
  }
  return report;
}

}  // namespace treeline::agent_report

#include "nav_agent/ros_log/robot_text.h"

#include <algorithm>
#include <array>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"

namespace treeline::ros_log {
namespace {

using core::RobotModel;

struct Measure {
  const char* name;
  double RobotModel::*member;
};
constexpr std::array<Measure, 16> kMeasures = {
    {{"front_m", &RobotModel::front_m},
     {"rear_m", &RobotModel::rear_m},
     {"half_width_m", &RobotModel::half_width_m},
     {"height_m", &RobotModel::height_m},
     {"ground_clearance_m", &RobotModel::ground_clearance_m},
     {"wheel_track_m", &RobotModel::wheel_track_m},
     {"wheel_radius_m", &RobotModel::wheel_radius_m},
     {"caster_m", &RobotModel::caster_m},
     {"max_step_m", &RobotModel::max_step_m},
     {"max_slope_rad", &RobotModel::max_slope_rad},
     {"max_forward_mps", &RobotModel::max_forward_mps},
     {"max_backward_mps", &RobotModel::max_backward_mps},
     {"max_yaw_rate_radps", &RobotModel::max_yaw_rate_radps},
     {"max_acceleration_mps2", &RobotModel::max_acceleration_mps2},
     {"max_deceleration_mps2", &RobotModel::max_deceleration_mps2},
     {"max_yaw_acceleration_radps2",
      &RobotModel::max_yaw_acceleration_radps2}}};

}  // namespace

std::string RobotText(const RobotModel& robot) {
  std::string text;
  for (const auto& [name, member] : kMeasures) {
    absl::StrAppendFormat(&text, "%s: %.17g\n", name, robot.*member);
  }
  return text;
}

absl::StatusOr<RobotModel> ParseRobotText(absl::string_view text) {
  RobotModel robot;
  for (const absl::string_view line :
       absl::StrSplit(text, '\n', absl::SkipWhitespace())) {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(line, absl::MaxSplits(": ", 1));
    const auto* measure = std::ranges::find_if(
        kMeasures,
        [&](const Measure& known) { return parts.first == known.name; });
    if (measure == kMeasures.end() ||
        !absl::SimpleAtod(parts.second, &(robot.*(measure->member)))) {
      return absl::InvalidArgumentError(
          absl::StrCat("robot: \"", line, "\" is no measure"));
    }
  }
  TL_RETURN_IF_ERROR(robot.Validate());
  return robot;
}

}  // namespace treeline::ros_log

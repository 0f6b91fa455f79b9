#include "nav_agent/core/robot_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::core {

geometry::Rigid3 RobotModel::UprightCamera(geometry::Vec3 position_in_base,
                                           double down_rad) {
  // Columns: the camera's right, down and forward in the base's frame.
  const double c = std::cos(down_rad);
  const double s = std::sin(down_rad);
  return {geometry::Rotation3::FromMatrix(
              geometry::Mat3{{0, -s, c, -1, 0, 0, 0, -c, -s}}),
          position_in_base};
}

double RobotModel::Circumradius_m() const {
  return std::hypot(std::max(front_m, rear_m), half_width_m);
}

absl::Status RobotModel::Validate() const {
  const std::pair<const char*, double> positive[] = {
      {"front_m", front_m},
      {"rear_m", rear_m},
      {"half_width_m", half_width_m},
      {"height_m", height_m},
      {"ground_clearance_m", ground_clearance_m},
      {"wheel_track_m", wheel_track_m},
      {"wheel_radius_m", wheel_radius_m},
      {"caster_m", caster_m},
      {"max_step_m", max_step_m},
      {"max_slope_rad", max_slope_rad},
      {"max_forward_mps", max_forward_mps},
      {"max_backward_mps", max_backward_mps},
      {"max_yaw_rate_radps", max_yaw_rate_radps},
      {"max_acceleration_mps2", max_acceleration_mps2},
      {"max_deceleration_mps2", max_deceleration_mps2},
      {"max_yaw_acceleration_radps2", max_yaw_acceleration_radps2}};
  for (const auto& [name, value] : positive) {
    if (!(value > 0) || !std::isfinite(value)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "robot: ", name, " is ", value, "; it must be positive"));
    }
  }
  if (wheel_track_m > 2 * half_width_m) {
    return absl::InvalidArgumentError(absl::StrCat(
        "robot: wheels ", wheel_track_m, " m apart stand out of a body ",
        2 * half_width_m, " m wide"));
  }
  if (caster_m > std::min(front_m, rear_m)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "robot: casters at ", caster_m, " m stand out of a body that reaches ",
        std::min(front_m, rear_m), " m from its axle"));
  }
  if (!geometry::IsFinite(base_from_laser) ||
      !geometry::IsFinite(base_from_rear_laser) ||
      !geometry::IsFinite(base_from_camera)) {
    return absl::InvalidArgumentError("robot: a sensor's pose is not finite");
  }
  return absl::OkStatus();
}

}  // namespace treeline::core

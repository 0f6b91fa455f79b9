#include "server/tools/calibration_text.h"

#include <numbers>

#include "absl/strings/str_format.h"

namespace treeline::tools {

std::string CalibrationText(const training::CalibrationReport& report) {
  const camera::RgbdCalibration& c = report.calibration;
  const geometry::Vec3 turn_deg =
      (180 / std::numbers::pi) *
      geometry::ToAxisAngle(c.color_from_depth.rotation);
  const geometry::Vec3 offset_cm = 100 * c.color_from_depth.translation;
  std::string text = absl::StrFormat(
      "colour camera     %s\n"
      "depth camera      %s\n"
      "color_from_depth  %.2f %.2f %.2f cm, %.2f %.2f %.2f deg\n"
      "depth scale       %.4f\n"
      "poses are of      the %s camera\n"
      "surfaces          %.1f -> %.1f mm apart, in %d pairs of %d frames\n",
      c.color.ToString(), c.depth.ToString(), offset_cm.x, offset_cm.y,
      offset_cm.z, turn_deg.x, turn_deg.y, turn_deg.z, c.depth_scale,
      c.pose_sensor == camera::RgbdSensor::kColor ? "colour" : "depth",
      1e3 * report.surface_rms_before_m, 1e3 * report.surface_rms_after_m,
      report.pairs, report.frames);
  if (report.edge_strength_after > 0) {
    absl::StrAppendFormat(
        &text, "depth edges meet  %.2f -> %.2f times the mean colour edge\n",
        report.edge_strength_before, report.edge_strength_after);
  }
  return text;
}

}  // namespace treeline::tools

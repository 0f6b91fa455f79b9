// A camera's calibration as people write it down.
#ifndef NAV_AGENT_DRIVERS_CAMERA_CALIBRATION_FILE_H_
#define NAV_AGENT_DRIVERS_CAMERA_CALIBRATION_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"

namespace treeline::camera_driver {

// YAML:
//   width: 640                           # of both images
//   height: 480
//   color: PINHOLE,525,525,319.5,239.5   # COLMAP's models; centre pixel (0, 0)
//   depth: PINHOLE,575,575,319.5,239.5   # left out: registered to colour
//   color_from_depth:                    # left out: none
//     translation_m: [0.025, 0, 0]
//     rotation_wxyz: [1, 0, 0, 0]
//   depth_scale: 1.0                     # left out: 1
// INVALID_ARGUMENT with "FILE:LINE: ".
absl::StatusOr<camera::RgbdCalibration> ParseCalibration(
    absl::string_view text, absl::string_view name);
// NOT_FOUND and so on name the file.
absl::StatusOr<camera::RgbdCalibration> ReadCalibration(
    const std::string& path);

}  // namespace treeline::camera_driver

#endif  // NAV_AGENT_DRIVERS_CAMERA_CALIBRATION_FILE_H_

// Where a recorded camera was, by its own pictures.
#ifndef NAV_AGENT_APP_CALIBRATE_CAMERA_VIEWS_H_
#define NAV_AGENT_APP_CALIBRATE_CAMERA_VIEWS_H_

#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/calibration/camera_calibration.h"
#include "nav_agent/ros_log/bag_to_log.h"

namespace treeline::calibrate_app {

struct CameraViews {
  std::vector<calibration::CameraView> views;
  int frames = 0;
};

// RGB-D odometry (RGB-D SLAM without loops) over the frames of the log, whose
// times are made those of `drive`. FAILED_PRECONDITION: the log has no frames
// with depth, or no calibration of the camera. CANCELLED.
absl::StatusOr<CameraViews> ViewsOfLog(const std::string& log,
                                       const ros_log::BagLogOptions& bag,
                                       const calibration::Drive& drive,
                                       const std::stop_token& stop);

// How far the floor is below a camera with this rotation (m), in every tenth
// frame of the log that shows it.
absl::StatusOr<std::vector<double>> HeightsOfLog(
    const std::string& log, const ros_log::BagLogOptions& bag,
    const geometry::Rotation3& base_from_camera);

}  // namespace treeline::calibrate_app

#endif  // NAV_AGENT_APP_CALIBRATE_CAMERA_VIEWS_H_

// What `treeline-agent calibrate` does, without its command line.
#ifndef NAV_AGENT_APP_CALIBRATE_CALIBRATE_RUN_H_
#define NAV_AGENT_APP_CALIBRATE_CALIBRATE_RUN_H_

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/calibration/calibration.h"
#include "nav_agent/calibration/camera_calibration.h"
#include "nav_agent/ros_log/bag_to_log.h"

namespace treeline::calibrate_app {

struct CalibrateOptions {
  std::string log;
  ros_log::BagLogOptions bag{};
  // Of a recording of ROS with two lasers; empty: there is one.
  std::string rear_scan_topic{};
  // A robot's file or a file of --hardware that says what is assumed; empty:
  // what the log says of its robot, or else the default robot.
  std::string robot{};
  // Whether the camera is calibrated, too: its pictures are followed.
  bool with_camera = false;
  // Written if not empty. `write` must be there, and is changed.
  std::string write{};
  std::string yaml{};
  std::string json{};
  std::string picture{};
  std::string corrected{};
};

struct CalibrateResult {
  calibration::Calibration calibration;
  // Of the laser that looks back: its place alone.
  std::optional<calibration::Calibration> rear;
  std::optional<calibration::CameraCalibration> camera;
  // What robot file says (of `write` the kind of that file).
  std::string yaml;
  std::vector<std::string> notes;
};

// The errors of reading, of Calibrate, and of writing.
absl::StatusOr<CalibrateResult> RunCalibration(const CalibrateOptions& options,
                                               const std::stop_token& stop);

// A robot's file (docs/reference/robots.md), a name of a robot, a file of
// --hardware, which names a `base`, or one of --ros2: of that robot, the track
// and where sensors are is as `recorded` has it.
absl::StatusOr<calibration::Setup> ReadSetup(
    const std::string& robot, const core::RobotModel& recorded = {});

// The log with all that is known put into effect, as an agent log at `to`:
// wheels, track, mount, stamps of scans. ALREADY_EXISTS.
absl::Status WriteCorrectedLog(const CalibrateOptions& options,
                               const calibration::Calibration& calibration,
                               bool has_gyroscope, const std::string& to);

}  // namespace treeline::calibrate_app

#endif  // NAV_AGENT_APP_CALIBRATE_CALIBRATE_RUN_H_

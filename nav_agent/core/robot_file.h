// Robots as configuration: measures, speeds and lasers by name, or from a file.
#ifndef NAV_AGENT_CORE_ROBOT_FILE_H_
#define NAV_AGENT_CORE_ROBOT_FILE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/core/odometry_noise.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::core {

// What a real robot's measurements are corrected by before they are used, as
// `treeline-agent calibrate` finds it. Recordings hold them uncorrected.
struct SensorCorrection {
  // What the wheels count is multiplied by (0.5 to 2).
  double left_scale = 1;
  double right_scale = 1;
  // What turns are multiplied by after that (0.5 to 2): of odometry whose turns
  // do not follow from how far wheels are apart.
  double turn_scale = 1;
  // Scans of the laser, and pictures of the camera, are stamped this much later
  // than wheel readings of the same moment (s, -0.5 to 0.5).
  double laser_delay_s = 0;
  double camera_delay_s = 0;

  constexpr bool operator==(const SensorCorrection&) const = default;
  // INVALID_ARGUMENT for what is not within these bounds.
  absl::Status Validate() const;
};

// At which end its charging contacts are; kUnsaid: each dock says so.
enum class ContactEnd : uint8_t { kUnsaid, kFront, kRear };
// "", "front" or "rear", as robots' files have it. INVALID_ARGUMENT: none of
// them.
absl::StatusOr<ContactEnd> ContactEndOf(absl::string_view name);

struct RobotDescription {
  std::string name;
  RobotModel model;
  RobotLasers lasers;
  SensorCorrection correction{};
  // nullopt: nobody measured it.
  std::optional<MeasuredOdometryNoise> noise{};
  ContactEnd contacts = ContactEnd::kUnsaid;

  absl::Status Validate() const;
};

// The robots that programs know: "rmp100", the thesis's Segway with a UTM-30LX
// ahead and a UST-10LX behind; "jackal", Clearpath's as the BARN challenge
// drives it, 0.508 x 0.430 m, with one laser of 270 degrees; "turtlebot3", the
// burger with its LDS-01.
std::vector<std::string> RobotNames();

// A YAML text (docs/reference/robots.md): `like` one of these, and what is
// otherwise. INVALID_ARGUMENT, "FILE:LINE: reason"; `name` is what errors call
// the file. Safe on any bytes.
absl::StatusOr<RobotDescription> ParseRobot(absl::string_view text,
                                            absl::string_view name);

// One of RobotNames(), or a file: ends in .yaml or contains a '/'.
absl::StatusOr<RobotDescription> ReadRobot(const std::string& name_or_path);

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_ROBOT_FILE_H_

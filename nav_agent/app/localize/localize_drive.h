// A recorded drive as localization wants it, whatever format it is in.
#ifndef NAV_AGENT_APP_LOCALIZE_LOCALIZE_DRIVE_H_
#define NAV_AGENT_APP_LOCALIZE_LOCALIZE_DRIVE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/recording/laser_log.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::localize_app {

struct DriveScan {
  // The middle of the scan.
  recording::RecordingTime stamp;
  // From above: ways are as a map has them, corrected for slopes.
  geometry::Rigid2 odom_from_base;
  // How the robot leans.
  geometry::Rotation3 level_from_base;
  std::vector<float> ranges_m;
  // Where it truly was, if the log knows.
  std::optional<geometry::Rigid3> world_from_base;
};

struct RecordedDrive {
  core::RangeSensorInfo laser;
  geometry::Rigid3 base_from_laser;
  // Whether tilt was measured.
  bool has_tilt = false;
  std::vector<DriveScan> scans;
  // Of an agent log: what was left out.
  int64_t refused_scans = 0;
  int64_t refused_readings = 0;
  int64_t damaged_bytes = 0;
};

struct DriveReadOptions {
  // Scans of an agent log that follow a used one sooner are left out (s, 0 or
  // more): lasers scan forty times a second.
  double min_interval_s = 0.09;
  // Odometry that is further from a scan than this does not tell where the
  // robot was then (s).
  double max_gap_s = 0.25;
};

// An agent log (docs/reference/agent-log.md), or what ReadLaserLog reads.
// Pictures are not decoded. Of an agent log, readings whose clock jumps back,
// that are not finite or lean too far, scans whose clock jumps back or with
// other numbers of beams than the laser has, and scans without odometry near
// are left out and counted.
//
// The errors of ReadLaserLog; FAILED_PRECONDITION if an agent log has no laser
// scanner, no usable scan, or no usable wheel reading.
absl::StatusOr<RecordedDrive> ReadDrive(const std::string& path,
                                        const DriveReadOptions& options = {});

// A public log as a drive on level ground.
RecordedDrive DriveOf(const recording::LaserLog& log);

}  // namespace treeline::localize_app

#endif  // NAV_AGENT_APP_LOCALIZE_LOCALIZE_DRIVE_H_

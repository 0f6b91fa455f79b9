// What a recorded drive says about a robot's wheels and its laser.
#ifndef NAV_AGENT_CALIBRATION_DRIVE_H_
#define NAV_AGENT_CALIBRATION_DRIVE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::calibration {

// Times are seconds since the first measurement.
struct DriveScan {
  double time_s = 0;
  // One for each beam (m), or none as in LaserScan.
  std::vector<float> ranges_m;
};

struct DriveReading {
  double time_s = 0;
  double left_m = 0;
  double right_m = 0;
  double yaw_rate_radps = 0;
};

struct Drive {
  core::RangeSensorInfo laser;
  // Of the log, or the default robot.
  core::RobotModel robot;
  bool has_robot = false;
  // In the order of time, strictly ascending.
  std::vector<DriveScan> scans;
  std::vector<DriveReading> readings;
  // A longer silence is a gap: some times of what is usual between scans or
  // between readings, but not less than kLongestGap_s.
  double longest_gap_s = 1;
  // Readings are near enough to each other to tell when wheels turned.
  bool shows_delay = true;
  // What was left out and what is odd, a sentence each.
  std::vector<std::string> notes;
  // When the drive began; nullopt: the clock jumped, so that stamps say
  // nothing.
  std::optional<base::MonotonicTime> begin;

  std::optional<double> TimeOf_s(base::MonotonicTime stamp) const {
    if (!begin) return std::nullopt;
    return base::SecondsBetween(*begin, stamp);
  }
};

// Puts a drive together from the entries of a log, in the log's order. Scans
// that are close to each other are thinned out. A clock that jumps back goes on
// after a gap, in which no motion is measured.
class DriveBuilder {
 public:
  void Take(const recording::LogEntry& entry);
  // FAILED_PRECONDITION says what is missing and what to record instead.
  absl::StatusOr<Drive> Build();

 private:
  // On the time of the drive; nullopt: before what there is already.
  std::optional<double> Continued(base::MonotonicTime stamp, double newest_s);
  void TakeScan(const core::LaserScan& scan);
  void TakeReading(const core::BaseReading& reading);

  Drive drive_;
  std::optional<base::MonotonicTime> first_;
  double moved_on_s_ = 0;
  double newest_s_ = 0;
  int64_t jumps_ = 0;
  int64_t all_scans_ = 0;
  int64_t other_scans_ = 0;
  int64_t bad_readings_ = 0;
  int64_t late_ = 0;
};

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_DRIVE_H_

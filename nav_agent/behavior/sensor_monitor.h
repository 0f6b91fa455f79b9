// Takes what the devices measured, leaves out invalid measurements, and
// says which device is lost.
#ifndef NAV_AGENT_BEHAVIOR_SENSOR_MONITOR_H_
#define NAV_AGENT_BEHAVIOR_SENSOR_MONITOR_H_

#include <optional>
#include <string>
#include <vector>

#include "nav_agent/behavior/navigator.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {

// Why the robot must stand.
struct StopReason {
  core::NavigationCause cause = core::NavigationCause::kNone;
  // For people: what is wrong.
  std::string text;
};

struct SensorMonitorOptions {
  // Of a slow laser it is longer: until its next scan can be there.
  double laser_timeout_s = kLaserTimeout_s;
  double odometry_timeout_s = kOdometryTimeout_s;
  // Stamps may be so far ahead of the clock (s).
  double future_s = kMaxFutureStamp_s;
  // A scan with ranges of fewer beams than this share tells nothing.
  double min_range_share = kMinRangeShare;
  // Readings that stay the same for so long while the base is told to move, or
  // says that it does, are a frozen device's (s).
  double frozen_s = kFrozen_s;
  // After so long of standing they are tried again, so often (s).
  double retry_s = kFrozenRetry_s;
  int retries = kFrozenRetries;
};

// Values that stay the same under new stamps. Not thread-safe.
class SameAgain {
 public:
  // The measurement is, or is not, equal to the one before it.
  void Add(bool is_same, base::MonotonicTime stamp) {
    if (!is_same) {
      since_.reset();
    } else if (!since_.has_value()) {
      since_ = stamp;
    }
  }
  void Restart() { since_.reset(); }
  double For_s(base::MonotonicTime stamp) const;

 private:
  std::optional<base::MonotonicTime> since_;
};

// Counts, and says whether a measurement may be used: it is newer than
// `newest`, and neither too old nor of the future.
bool AcceptStamp(base::MonotonicTime stamp, base::MonotonicTime now,
                 double timeout_s, const SensorMonitorOptions& options,
                 std::optional<base::MonotonicTime> newest, SensorTally& tally);

// One laser's scans. Not thread-safe.
class LaserWatch {
 public:
  // `name` for people. What is given must outlive it.
  LaserWatch(const char* name, core::RangeSensor& laser,
             const SensorMonitorOptions& options)
      : name_(name), laser_(&laser), options_(&options) {}

  // moved: how far the robot has moved since the last Poll (m and rad, added
  // up).
  void Poll(base::MonotonicTime now, double moved);
  // What can be used of it, oldest first.
  const std::vector<core::LaserScan>& scans() const { return scans_; }
  const SensorTally& tally() const { return tally_; }
  bool has_begun() const { return stamp_.has_value(); }
  // Why it is lost, if it is; begun: when somebody first listened.
  std::optional<std::string> Problem(base::MonotonicTime begun,
                                     base::MonotonicTime now) const;

 private:
  double Timeout_s() const;
  void Judge(const core::LaserScan& scan);

  const char* name_;
  core::RangeSensor* laser_;
  const SensorMonitorOptions* options_;
  std::vector<core::LaserScan> scans_;
  SensorTally tally_;
  // As it was when the last usable scan came.
  SensorTally tally_then_;
  std::optional<base::MonotonicTime> stamp_;
  std::vector<float> last_ranges_m_;
  SameAgain same_ranges_;
  // Since ranges stay the same.
  double moved_ = 0;
  bool is_frozen_ = false;
};

// Not thread-safe.
class SensorMonitor {
 public:
  SensorMonitor(const NavigatorDevices& devices,
                const SensorMonitorOptions& options);

  // What has arrived. command: what the base was told last.
  void Poll(base::MonotonicTime now, const core::VelocityCommand& command);
  // What of it can be used, oldest first.
  const std::vector<core::LaserScan>& scans() const { return laser_.scans(); }
  // Of the laser that looks back; none where there is none.
  const std::vector<core::LaserScan>& rear_scans() const;
  const std::vector<core::BaseReading>& readings() const { return readings_; }
  // The newest frame since the last call; renders pictures in simulations.
  std::optional<core::RgbdFrame> TakeFrame(base::MonotonicTime now);

  // The base's answer to the last command.
  void NoteBaseAnswer(const absl::Status& answer);

  // Of the last Poll: what is lost, the most serious first.
  std::vector<StopReason> Problems() const;
  // Whether laser and odometry have been heard at all.
  bool has_begun() const {
    return laser_.has_begun() && odometry_stamp_.has_value();
  }

  const SensorTally& laser() const { return laser_.tally(); }
  SensorTally rear_laser() const {
    return rear_laser_.has_value() ? rear_laser_->tally() : SensorTally();
  }
  const SensorTally& odometry() const { return odometry_; }
  const SensorTally& camera() const { return camera_; }
  // The newest usable reading.
  const std::optional<core::BaseReading>& reading() const { return reading_; }

 private:
  void PollOdometry(base::MonotonicTime now,
                    const core::VelocityCommand& command);
  void JudgeOdometry(const core::BaseReading& reading, bool is_same);
  std::optional<std::string> OdometryProblem() const;
  std::optional<std::string> BaseProblem() const;

  NavigatorDevices devices_;
  SensorMonitorOptions options_;
  base::MonotonicTime now_;
  std::optional<base::MonotonicTime> begun_;

  LaserWatch laser_;
  std::optional<LaserWatch> rear_laser_;
  std::vector<core::BaseReading> readings_;
  SensorTally odometry_;
  SensorTally camera_;
  // As it was when the last usable reading came.
  SensorTally odometry_then_;
  std::optional<base::MonotonicTime> odometry_stamp_;
  std::optional<base::MonotonicTime> camera_stamp_;

  // In the readings of the last Poll (m and rad, added up).
  double moved_ = 0;
  std::optional<core::BaseReading> reading_;
  SameAgain same_readings_;
  std::optional<base::MonotonicTime> odometry_frozen_;
  int odometry_retries_ = 0;

  absl::Status base_answer_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SENSOR_MONITOR_H_

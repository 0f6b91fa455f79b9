// A recorded drive, as it is to be understood by a robot calibrated by itself.
#ifndef NAV_AGENT_APP_MAP_CALIBRATED_LOG_H_
#define NAV_AGENT_APP_MAP_CALIBRATED_LOG_H_

#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "common/base/temporary_folder.h"
#include "nav_agent/core/odometry_noise.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::map_app {

// A temporary agent log: the drive with the wheels, the laser's place and its
// delay that make its wheels and scans agree best.
class CalibratedLog {
 public:
  // robot: a file of what is assumed; empty: what the log says. Makes little of
  // what the drive does not show. The errors of RunCalibration, as of a drive
  // that is too short for it.
  static absl::StatusOr<CalibratedLog> Make(const std::string& log,
                                            const std::string& robot,
                                            const std::stop_token& stop);

  std::string path() const { return folder_.path() + "/log.tlog"; }
  // What was found, for people.
  const std::string& summary() const { return summary_; }
  bool has_gyroscope() const { return has_gyroscope_; }
  // Of its odometry; nullopt: the drive does not show it.
  const std::optional<core::MeasuredOdometryNoise>& noise() const {
    return noise_;
  }
  // Its scans are stamped this much earlier than in the log that it was.
  recording::RecordingTime::duration scan_delay() const { return scan_delay_; }

 private:
  explicit CalibratedLog(base::TemporaryFolder folder)
      : folder_(std::move(folder)) {}

  base::TemporaryFolder folder_;
  std::string summary_;
  bool has_gyroscope_ = false;
  std::optional<core::MeasuredOdometryNoise> noise_;
  recording::RecordingTime::duration scan_delay_{};
};

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_CALIBRATED_LOG_H_

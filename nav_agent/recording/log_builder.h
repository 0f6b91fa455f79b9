// What the readers of laser logs share: checks, order, geometry.
#ifndef NAV_AGENT_RECORDING_LOG_BUILDER_H_
#define NAV_AGENT_RECORDING_LOG_BUILDER_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline::recording {

// Where the beams of a scanner are, of which only their number is known.
core::RangeSensorInfo SickGeometry(int beams);

// Puts a log together from its lines. Errors are LineErrors.
class LogBuilder {
 public:
  LogBuilder(std::string name, const LaserLogOptions& options)
      : name_(std::move(name)), options_(options) {}

  // `laser` may differ between scans in nothing. ranges_m are as in the file.
  absl::Status AddScan(int line, RecordingTime stamp,
                       const geometry::Rigid2& odom_from_base,
                       const core::RangeSensorInfo& laser,
                       std::vector<float> ranges_m);
  absl::Status AddOdometry(int line, RecordingTime stamp,
                           const geometry::Rigid2& odom_from_base);
  // Where the file says that the laser is. Call for every scan, or never.
  void AddMount(const geometry::Rigid2& base_from_laser) {
    mounts_.push_back(base_from_laser);
  }
  // Sorts; fails if there are no scans.
  absl::StatusOr<LaserLog> Build();

 private:
  // The mount that all scans agree on; else none: some programs write a
  // corrected pose of the robot where the laser's belongs.
  geometry::Rigid2 CommonMount() const;
  // The stamp, moved on if the clock has jumped back until then.
  absl::StatusOr<RecordingTime> Continued(int line, RecordingTime stamp,
                                          RecordingTime* newest, bool first);

  const std::string name_;
  const LaserLogOptions options_;
  LaserLog log_;
  std::vector<geometry::Rigid2> mounts_;
  // By how much stamps are moved on, after how many jumps.
  RecordingTime::duration moved_on_{};
  int jumps_ = 0;
  RecordingTime newest_scan_;
  RecordingTime newest_odometry_;
};

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_LOG_BUILDER_H_

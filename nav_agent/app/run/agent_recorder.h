// What the sensors say, into an agent log, while somebody drives by it.
#ifndef NAV_AGENT_APP_RUN_AGENT_RECORDER_H_
#define NAV_AGENT_APP_RUN_AGENT_RECORDER_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::run_app {

// Thread-safe. A log that cannot be written any more (a full disk) ends the
// recording, and nothing else.
class AgentRecorder {
 public:
  // ALREADY_EXISTS: the log. on_failure: called once, if writing fails. clock:
  // real time; it and what on_failure uses must outlive the recorder.
  static absl::StatusOr<std::unique_ptr<AgentRecorder>> Open(
      const std::string& path, const core::RobotModel& robot,
      const base::Clock& clock,
      std::function<void(const absl::Status&)> on_failure);

  void Add(const core::RangeSensorInfo& info, const core::LaserScan& scan);
  void Add(const core::BaseReading& reading);
  // Encodes the frame: not for a thread in a hurry.
  void Add(const camera::RgbdCalibration& calibration,
           const core::RgbdFrame& frame);
  absl::Status Flush();

 private:
  AgentRecorder(std::unique_ptr<recording::AgentLogWriter> log,
                std::function<void(const absl::Status&)> on_failure)
      : log_(std::move(log)), on_failure_(std::move(on_failure)) {}
  void Write(const recording::LogEntry& entry)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  absl::Mutex mutex_;
  // Null once writing has failed.
  std::unique_ptr<recording::AgentLogWriter> log_ ABSL_GUARDED_BY(mutex_);
  const std::function<void(const absl::Status&)> on_failure_;
  std::optional<core::RangeSensorInfo> info_ ABSL_GUARDED_BY(mutex_);
  std::optional<camera::RgbdCalibration> calibration_ ABSL_GUARDED_BY(mutex_);
};

// A laser and wheels whose measurements are recorded as they are taken. All
// must outlive them.
class RecordedLaser final : public core::RangeSensor {
 public:
  RecordedLaser(core::RangeSensor& laser, AgentRecorder& recorder)
      : laser_(laser), recorder_(recorder) {}

  core::RangeSensorInfo Info() const override { return laser_.Info(); }
  std::vector<core::LaserScan> TakeScans() override;
  core::DeviceHealth Health() const override { return laser_.Health(); }

 private:
  core::RangeSensor& laser_;
  AgentRecorder& recorder_;
};

class RecordedOdometry final : public core::Odometry {
 public:
  RecordedOdometry(core::Odometry& odometry, AgentRecorder& recorder)
      : odometry_(odometry), recorder_(recorder) {}

  std::vector<core::BaseReading> TakeReadings() override;
  core::DeviceHealth Health() const override { return odometry_.Health(); }

 private:
  core::Odometry& odometry_;
  AgentRecorder& recorder_;
};

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_AGENT_RECORDER_H_

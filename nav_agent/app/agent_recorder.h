// What the sensors say, into an agent log, while somebody drives by it.
#ifndef NAV_AGENT_APP_AGENT_RECORDER_H_
#define NAV_AGENT_APP_AGENT_RECORDER_H_

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

namespace treeline {

// Thread-safe. A log that cannot be written any more (a full disk) ends the
// recording, and nothing else.
class AgentRecorder {
 public:
  // ALREADY_EXISTS: the log. on_failure: called once, if writing fails. clock:
  // real time; it and what on_failure uses must outlive the recorder.
  static absl::StatusOr<std::unique_ptr<AgentRecorder>> Open(
      const std::string& path, const RobotModel& robot, const Clock& clock,
      std::function<void(const absl::Status&)> on_failure);

  void Add(const RangeSensorInfo& info, const LaserScan& scan);
  void Add(const BaseReading& reading);
  // Encodes the frame: not for a thread in a hurry.
  void Add(const RgbdCalibration& calibration, const RgbdFrame& frame);
  absl::Status Flush();

 private:
  AgentRecorder(std::unique_ptr<AgentLogWriter> log,
                std::function<void(const absl::Status&)> on_failure)
      : log_(std::move(log)), on_failure_(std::move(on_failure)) {}
  void Write(const LogEntry& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  absl::Mutex mutex_;
  // Null once writing has failed.
  std::unique_ptr<AgentLogWriter> log_ ABSL_GUARDED_BY(mutex_);
  const std::function<void(const absl::Status&)> on_failure_;
  std::optional<RangeSensorInfo> info_ ABSL_GUARDED_BY(mutex_);
  std::optional<RgbdCalibration> calibration_ ABSL_GUARDED_BY(mutex_);
};

// A laser and wheels whose measurements are recorded as they are taken. All
// must outlive them.
class RecordedLaser final : public RangeSensor {
 public:
  RecordedLaser(RangeSensor& laser, AgentRecorder& recorder)
      : laser_(laser), recorder_(recorder) {}

  RangeSensorInfo Info() const override { return laser_.Info(); }
  std::vector<LaserScan> TakeScans() override;
  DeviceHealth Health() const override { return laser_.Health(); }

 private:
  RangeSensor& laser_;
  AgentRecorder& recorder_;
};

class RecordedOdometry final : public Odometry {
 public:
  RecordedOdometry(Odometry& odometry, AgentRecorder& recorder)
      : odometry_(odometry), recorder_(recorder) {}

  std::vector<BaseReading> TakeReadings() override;
  DeviceHealth Health() const override { return odometry_.Health(); }

 private:
  Odometry& odometry_;
  AgentRecorder& recorder_;
};

}  // namespace treeline

#endif  // NAV_AGENT_APP_AGENT_RECORDER_H_

#include "nav_agent/app/run/agent_recorder.h"

#include <utility>

#include "common/base/status_macros.h"

namespace treeline::run_app {
namespace {

constexpr int kJpegQuality = 92;

}  // namespace

absl::StatusOr<std::unique_ptr<AgentRecorder>> AgentRecorder::Open(
    const std::string& path, const core::RobotModel& robot,
    const base::Clock& clock,
    std::function<void(const absl::Status&)> on_failure) {
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<recording::AgentLogWriter> log,
      recording::AgentLogWriter::Open(path, /*append=*/false, clock));
  TL_RETURN_IF_ERROR(
      log->Write(recording::LogInformation{"treeline-agent run"}));
  TL_RETURN_IF_ERROR(log->Write(robot));
  return std::unique_ptr<AgentRecorder>(
      new AgentRecorder(std::move(log), std::move(on_failure)));
}

void AgentRecorder::Write(const recording::LogEntry& entry) {
  if (log_ == nullptr) return;
  const absl::Status written = log_->Write(entry);
  if (written.ok()) return;
  log_ = nullptr;
  on_failure_(written);
}

void AgentRecorder::Add(const core::RangeSensorInfo& info,
                        const core::LaserScan& scan) {
  const absl::MutexLock lock(&mutex_);
  if (info_ != info) {
    Write(info);
    info_ = info;
  }
  Write(scan);
}

void AgentRecorder::Add(const core::BaseReading& reading) {
  const absl::MutexLock lock(&mutex_);
  Write(reading);
}

void AgentRecorder::Add(const camera::RgbdCalibration& calibration,
                        const core::RgbdFrame& frame) {
  absl::StatusOr<recording::LogFrame> encoded =
      recording::EncodeLogFrame(frame, kJpegQuality);
  // A frame that is none is not worth a recording.
  if (!encoded.ok()) return;
  const absl::MutexLock lock(&mutex_);
  if (calibration_ != calibration) {
    Write(calibration);
    calibration_ = calibration;
  }
  Write(*std::move(encoded));
}

absl::Status AgentRecorder::Flush() {
  const absl::MutexLock lock(&mutex_);
  return log_ == nullptr ? absl::OkStatus() : log_->Flush();
}

std::vector<core::LaserScan> RecordedLaser::TakeScans() {
  std::vector<core::LaserScan> scans = laser_.TakeScans();
  for (const core::LaserScan& scan : scans) recorder_.Add(laser_.Info(), scan);
  return scans;
}

std::vector<core::BaseReading> RecordedOdometry::TakeReadings() {
  std::vector<core::BaseReading> readings = odometry_.TakeReadings();
  for (const core::BaseReading& reading : readings) recorder_.Add(reading);
  return readings;
}

}  // namespace treeline::run_app

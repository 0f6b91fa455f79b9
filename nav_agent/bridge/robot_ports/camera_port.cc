#include "nav_agent/bridge/robot_ports/camera_port.h"

#include <utility>

#include "common/ros2/conversions/geometry_values.h"

namespace treeline::robot_ports {

absl::Status CameraPort::AddInfo(const messages::CameraInfo& info) {
  const absl::MutexLock lock(&mutex_);
  const absl::Status status = input_.AddInfo(info);
  return status.ok() ? status : health_.NoteBroken(status);
}

void CameraPort::AddColor(place_finder::Picture picture) {
  const absl::MutexLock lock(&mutex_);
  health_.NoteGood(real_clock_.Now());
  input_.AddColor(std::move(picture));
}

void CameraPort::AddDepth(place_finder::Picture picture) {
  const absl::MutexLock lock(&mutex_);
  input_.AddDepth(std::move(picture));
}

std::string CameraPort::frame_id() const {
  const absl::MutexLock lock(&mutex_);
  return input_.frame_id();
}

bool CameraPort::has_info() const {
  const absl::MutexLock lock(&mutex_);
  return input_.camera().has_value();
}

camera::RgbdCalibration CameraPort::Calibration() const {
  const absl::MutexLock lock(&mutex_);
  if (!input_.camera().has_value()) return {};
  return {.color = *input_.camera(),
          .depth = *input_.camera(),
          .color_from_depth = {}};
}

std::vector<core::RgbdFrame> CameraPort::TakeFrames() {
  std::optional<place_finder::CameraInput> copy;
  {
    const absl::MutexLock lock(&mutex_);
    const base::MonotonicTime now = real_clock_.Now();
    const std::optional<base::MonotonicTime> stamp = input_.NewestStamp();
    if (!stamp.has_value() || stamp == stamp_ ||
        (taken_.has_value() &&
         base::SecondsBetween(*taken_, now) < interval_s_)) {
      return {};
    }
    taken_ = now;
    stamp_ = stamp;
    // Decoding takes milliseconds, in which scans must not wait.
    copy = input_;
  }
  absl::StatusOr<core::RgbdFrame> frame = copy->Newest();
  if (!frame.ok()) {
    const absl::MutexLock lock(&mutex_);
    health_.NoteBroken(frame.status()).IgnoreError();
    return {};
  }
  frame->stamp = time_.TimeOf(conversions::StampOf(frame->stamp));
  std::vector<core::RgbdFrame> frames;
  frames.push_back(*std::move(frame));
  return frames;
}

core::DeviceHealth CameraPort::Health() const {
  const absl::MutexLock lock(&mutex_);
  return health_.At(real_clock_.Now());
}

}  // namespace treeline::robot_ports

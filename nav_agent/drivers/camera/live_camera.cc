#include "nav_agent/drivers/camera/live_camera.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::camera_driver {
namespace {

constexpr std::chrono::milliseconds kReadTimeout(100);
constexpr std::chrono::nanoseconds kAtOnce(0);

}  // namespace

absl::Status LiveCameraOptions::Validate() const {
  if (!(silence_s >= 0.2) || !(silence_s <= 60)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a camera's silence_s of ", silence_s, " is outside [0.2, 60]"));
  }
  if (max_waiting < 1 || max_waiting > core::kMaxWaiting) {
    return absl::InvalidArgumentError(
        absl::StrCat("a camera's max_waiting of ", max_waiting,
                     " is outside [1, ", core::kMaxWaiting, "]"));
  }
  return backoff.Validate();
}

CameraWorker::CameraWorker(const LiveCameraOptions& options,
                           CameraOpener& opener, const base::Clock& clock,
                           FrameQueue& queue)
    : options_(options),
      opener_(opener),
      clock_(clock),
      queue_(queue),
      backoff_(options.backoff, options.seed) {}

camera::RgbdCalibration CameraWorker::calibration() const {
  absl::MutexLock lock(&mutex_);
  return calibration_;
}

std::chrono::nanoseconds CameraWorker::Step() {
  if (device_ == nullptr) return Open();
  absl::StatusOr<std::optional<core::RgbdFrame>> frame =
      device_->Read(kReadTimeout);
  if (frame.ok() && frame->has_value()) {
    Take(**std::move(frame));
    return kAtOnce;
  }
  if (absl::IsDataLoss(frame.status())) {
    queue_.CountCorrupt();
  } else if (!frame.ok()) {
    return GiveUp(frame.status());
  }
  const std::chrono::duration<double> silence = clock_.Now() - last_frame_at_;
  if (silence.count() < options_.silence_s) return kAtOnce;
  return GiveUp(absl::UnavailableError(
      absl::StrCat("the camera is there, but has sent no good frame for ",
                   options_.silence_s,
                   " s: plug it in again, into another port if need be")));
}

std::chrono::nanoseconds CameraWorker::Open() {
  absl::StatusOr<std::unique_ptr<CameraDevice>> device = opener_.Open();
  if (!device.ok()) return GiveUp(device.status());
  device_ = *std::move(device);
  last_frame_at_ = clock_.Now();
  sequence_offset_.reset();
  absl::MutexLock lock(&mutex_);
  calibration_ = device_->Calibration();
  return kAtOnce;
}

std::chrono::nanoseconds CameraWorker::GiveUp(const absl::Status& cause) {
  device_.reset();
  queue_.SetLost(cause);
  return backoff_.Next();
}

void CameraWorker::Take(core::RgbdFrame frame) {
  backoff_.Reset();
  last_frame_at_ = clock_.Now();
  if (!sequence_offset_) sequence_offset_ = next_sequence_ - frame.sequence;
  // A device that counts backwards has begun anew.
  if (frame.sequence + *sequence_offset_ < next_sequence_) {
    sequence_offset_ = next_sequence_ - frame.sequence;
  }
  frame.sequence += *sequence_offset_;
  next_sequence_ = frame.sequence + 1;
  // The device's clock is known better after a few frames than at the first.
  frame.stamp = last_stamp_ = std::max(frame.stamp, last_stamp_);
  if (!frame.frame.calibration) frame.frame.calibration = calibration();
  queue_.Push(std::move(frame));
}

absl::StatusOr<std::unique_ptr<LiveCamera>> LiveCamera::Create(
    const LiveCameraOptions& options, std::unique_ptr<CameraOpener> opener,
    const base::Clock& clock) {
  if (absl::Status status = options.Validate(); !status.ok()) return status;
  if (opener == nullptr) {
    return absl::InvalidArgumentError("the camera has no opener");
  }
  return std::unique_ptr<LiveCamera>(
      new LiveCamera(options, std::move(opener), clock));
}

LiveCamera::LiveCamera(const LiveCameraOptions& options,
                       std::unique_ptr<CameraOpener> opener,
                       const base::Clock& clock)
    : opener_(std::move(opener)),
      queue_(options.max_waiting),
      worker_(options, *opener_, clock, queue_),
      thread_([this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          const std::chrono::nanoseconds wait = worker_.Step();
          if (wait > kAtOnce) stream::StopRequestedWithin(wait, stop);
        }
      }) {}

LiveCamera::~LiveCamera() {
  thread_.request_stop();
  thread_.join();
}

camera::RgbdCalibration LiveCamera::Calibration() const {
  return worker_.calibration();
}

std::vector<core::RgbdFrame> LiveCamera::TakeFrames() { return queue_.Take(); }

core::DeviceHealth LiveCamera::Health() const { return queue_.Health(); }

}  // namespace treeline::camera_driver

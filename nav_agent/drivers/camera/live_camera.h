// What cameras that are plugged in have in common: they are looked for, read,
// lost and found again.
#ifndef NAV_AGENT_DRIVERS_CAMERA_LIVE_CAMERA_H_
#define NAV_AGENT_DRIVERS_CAMERA_LIVE_CAMERA_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/drivers/camera/frame_queue.h"
#include "nav_agent/drivers/stream/backoff.h"

namespace treeline::camera_driver {

// One camera that has been opened, closed by its destructor. Used by one
// thread.
class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  virtual camera::RgbdCalibration Calibration() const = 0;
  // Waits at most `timeout` for a frame; nullopt if there was none. Its
  // sequence numbers are those of the device. DATA_LOSS for a frame that came
  // broken or in half; with any other error the device is of no more use.
  virtual absl::StatusOr<std::optional<core::RgbdFrame>> Read(
      std::chrono::milliseconds timeout) = 0;
};

class CameraOpener {
 public:
  virtual ~CameraOpener() = default;
  // Errors say what to do, and may go away by themselves.
  virtual absl::StatusOr<std::unique_ptr<CameraDevice>> Open() = 0;
};

struct LiveCameraOptions {
  // A camera that sends nothing for this long is closed and opened again.
  // [0.2, 60]
  double silence_s = 2.0;
  // From 1 to kMaxWaiting; a frame of 640 x 480 with depth takes 1.5 MB.
  int max_waiting = 8;
  stream::BackoffOptions backoff{};
  uint64_t seed = 0;

  absl::Status Validate() const;
};

// The work of LiveCamera, a step at a time and without a thread. Not
// thread-safe but for calibration().
class CameraWorker {
 public:
  CameraWorker(const LiveCameraOptions& options, CameraOpener& opener,
               const base::Clock& clock, FrameQueue& queue);

  // Opens the camera, or reads a frame of it. Returns how long to wait before
  // the next step.
  std::chrono::nanoseconds Step();
  // That of the camera that was opened last.
  camera::RgbdCalibration calibration() const;

 private:
  std::chrono::nanoseconds Open();
  std::chrono::nanoseconds GiveUp(const absl::Status& cause);
  void Take(core::RgbdFrame frame);

  const LiveCameraOptions options_;
  CameraOpener& opener_;
  const base::Clock& clock_;
  FrameQueue& queue_;
  stream::Backoff backoff_;
  std::unique_ptr<CameraDevice> device_;
  base::MonotonicTime last_frame_at_;
  base::MonotonicTime last_stamp_;
  // Ours less the device's; known from its first frame.
  std::optional<int64_t> sequence_offset_;
  int64_t next_sequence_ = 0;
  mutable absl::Mutex mutex_;
  camera::RgbdCalibration calibration_ ABSL_GUARDED_BY(mutex_);
};

// Reads a camera on a thread of its own. Thread-safe. Frames carry their
// calibration, and their stamps never run backwards. Sequence numbers go on
// when a camera is found again; the gap that its absence left is not counted.
class LiveCamera final : public core::RgbdCamera {
 public:
  // Begins to look for the camera. The clock is the steady one, or another
  // that runs as fast, and outlives the camera.
  static absl::StatusOr<std::unique_ptr<LiveCamera>> Create(
      const LiveCameraOptions& options, std::unique_ptr<CameraOpener> opener,
      const base::Clock& clock);
  ~LiveCamera() override;

  camera::RgbdCalibration Calibration() const override;
  std::vector<core::RgbdFrame> TakeFrames() override;
  core::DeviceHealth Health() const override;

 private:
  LiveCamera(const LiveCameraOptions& options,
             std::unique_ptr<CameraOpener> opener, const base::Clock& clock);

  const std::unique_ptr<CameraOpener> opener_;
  FrameQueue queue_;
  CameraWorker worker_;
  std::jthread thread_;
};

}  // namespace treeline::camera_driver

#endif  // NAV_AGENT_DRIVERS_CAMERA_LIVE_CAMERA_H_

// Who looks over the robot's shoulder: devices that hand on what another has,
// and keep the newest picture for people.
#ifndef NAV_AGENT_SERVICE_DEVICE_TAPS_H_
#define NAV_AGENT_SERVICE_DEVICE_TAPS_H_

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/core/relocalization.h"

namespace treeline::agent_service {

// The newest colour picture of somebody's frames, as JPEG when it is asked for.
// Thread-safe.
class PictureKeeper {
 public:
  // Copies the colour of every picture that is at least this much newer than
  // the last one.
  explicit PictureKeeper(base::MonotonicTime::duration interval)
      : interval_(interval) {}

  void Keep(const core::RgbdFrame& frame);
  // Draws a dot at each of these pixels into the picture of that stamp, if it
  // is still the newest. What lies outside is left out.
  void Mark(base::MonotonicTime stamp, std::span<const geometry::Vec2> pixels);
  // NOT_FOUND: there is none yet.
  absl::StatusOr<std::shared_ptr<const std::string>> Jpeg() const;

 private:
  const base::MonotonicTime::duration interval_;
  mutable absl::Mutex mutex_;
  std::shared_ptr<const image::ColorImage> image_ ABSL_GUARDED_BY(mutex_);
  std::optional<base::MonotonicTime> stamp_ ABSL_GUARDED_BY(mutex_);
  // Of image_; null until somebody asks.
  mutable std::shared_ptr<const std::string> jpeg_ ABSL_GUARDED_BY(mutex_);
};

// A camera whose frames are taken by a thread of its own: rendering, decoding
// and recording them makes nobody else wait. The newest few are kept for who
// takes them.
class BackgroundCamera final : public core::RgbdCamera {
 public:
  // on_frame: called by that thread for every frame. All must outlive it.
  BackgroundCamera(core::RgbdCamera& camera,
                   std::function<void(const core::RgbdFrame&)> on_frame);
  ~BackgroundCamera() override = default;

  camera::RgbdCalibration Calibration() const override {
    return camera_.Calibration();
  }
  std::vector<core::RgbdFrame> TakeFrames() override;
  core::DeviceHealth Health() const override { return camera_.Health(); }

 private:
  static constexpr size_t kKept = 4;

  void Run(const std::stop_token& stop);

  core::RgbdCamera& camera_;
  const std::function<void(const core::RgbdFrame&)> on_frame_;
  absl::Mutex mutex_;
  std::deque<core::RgbdFrame> frames_ ABSL_GUARDED_BY(mutex_);
  // The last member: it uses all of them.
  std::jthread thread_;
};

// A relocalization server whose questions are kept, with the pixels that
// support the answer drawn in. Both must outlive it.
class WatchedServer final : public core::RelocalizationPort {
 public:
  WatchedServer(core::RelocalizationPort& port, PictureKeeper& keeper)
      : port_(port), keeper_(keeper) {}

  void Ask(const core::RgbdFrame& frame, double timeout_s) override;
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> TakeAnswer()
      override;
  bool IsAsking() const override { return port_.IsAsking(); }
  void Cancel() override { port_.Cancel(); }

  // What became of the last question; OK before the first.
  absl::Status last_error() const;

 private:
  core::RelocalizationPort& port_;
  PictureKeeper& keeper_;
  mutable absl::Mutex mutex_;
  absl::Status last_error_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_DEVICE_TAPS_H_

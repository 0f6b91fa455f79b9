// Who looks over the robot's shoulder: devices that hand on what another has,
// and keep the newest picture for people.
#ifndef NAV_AGENT_SERVICE_DEVICE_TAPS_H_
#define NAV_AGENT_SERVICE_DEVICE_TAPS_H_

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/core/relocalization.h"

namespace treeline {

// The newest colour picture of somebody's frames, as JPEG when it is asked for.
// Thread-safe.
class PictureKeeper {
 public:
  // Copies the colour of every picture that is at least this much newer than
  // the last one.
  explicit PictureKeeper(MonotonicTime::duration interval)
      : interval_(interval) {}

  void Keep(const RgbdFrame& frame);
  // NOT_FOUND: there is none yet.
  absl::StatusOr<std::shared_ptr<const std::string>> Jpeg() const;

 private:
  const MonotonicTime::duration interval_;
  mutable absl::Mutex mutex_;
  std::shared_ptr<const ColorImage> image_ ABSL_GUARDED_BY(mutex_);
  std::optional<MonotonicTime> stamp_ ABSL_GUARDED_BY(mutex_);
  // Of image_; null until somebody asks.
  mutable std::shared_ptr<const std::string> jpeg_ ABSL_GUARDED_BY(mutex_);
};

// A camera whose pictures are kept. Both must outlive it.
class WatchedCamera final : public RgbdCamera {
 public:
  WatchedCamera(RgbdCamera& camera, PictureKeeper& keeper)
      : camera_(camera), keeper_(keeper) {}

  RgbdCalibration Calibration() const override { return camera_.Calibration(); }
  std::vector<RgbdFrame> TakeFrames() override;
  DeviceHealth Health() const override { return camera_.Health(); }

 private:
  RgbdCamera& camera_;
  PictureKeeper& keeper_;
};

// A relocalization server whose questions are kept. Both must outlive it.
class WatchedServer final : public RelocalizationPort {
 public:
  WatchedServer(RelocalizationPort& port, PictureKeeper& keeper)
      : port_(port), keeper_(keeper) {}

  void Ask(const RgbdFrame& frame, double timeout_s) override;
  std::optional<absl::StatusOr<RelocalizationAnswer>> TakeAnswer() override;
  bool IsAsking() const override { return port_.IsAsking(); }
  void Cancel() override { port_.Cancel(); }

  // What became of the last question; OK before the first.
  absl::Status last_error() const;

 private:
  RelocalizationPort& port_;
  PictureKeeper& keeper_;
  mutable absl::Mutex mutex_;
  absl::Status last_error_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline

#endif  // NAV_AGENT_SERVICE_DEVICE_TAPS_H_

// A recording that behaves like a camera.
#ifndef NAV_AGENT_DRIVERS_CAMERA_REPLAY_REPLAY_CAMERA_H_
#define NAV_AGENT_DRIVERS_CAMERA_REPLAY_REPLAY_CAMERA_H_

#include <cstdint>
#include <deque>
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
#include "common/dataset/dataset.h"
#include "nav_agent/core/devices.h"

namespace treeline::replay_camera {

struct ReplayCameraOptions {
  // 2: twice as fast as it was recorded. (0, 1000]
  double rate = 1.0;
  // Begin again after the last frame.
  bool loop = false;
  // Where in the recording to begin (s).
  double begin_s = 0;
  // Frames are decoded ahead of their time: so many at most. [1, kMaxWaiting]
  int decode_ahead = 4;

  absl::Status Validate() const;
};

// Frame k is handed over once the clock says that it is due:
//   stamp = start + (time of frame k - begin_s) / rate
// by dataset::FrameTimes, of which the first counts as 0.
// No frame is late for a clock that stands still, and none missing for one
// that is quick: TakeFrames returns exactly what has become due since it was
// called last (of more than kMaxWaiting frames the latest). Frames are decoded
// ahead on a thread; if that has not caught up, TakeFrames waits for it, so
// that what is returned depends on the clock alone. Frames that cannot be read
// are left out and counted as corrupt. A recording that has ended is a camera
// that was lost, with OUT_OF_RANGE as its cause. Thread-safe.
class ReplayCamera final : public core::RgbdCamera {
 public:
  static absl::StatusOr<std::unique_ptr<ReplayCamera>> Create(
      const ReplayCameraOptions& options, dataset::Dataset dataset,
      const base::Clock& clock);
  ~ReplayCamera() override;

  camera::RgbdCalibration Calibration() const override;
  std::vector<core::RgbdFrame> TakeFrames() override;
  core::DeviceHealth Health() const override;

  // From here on, as if the recording had been begun at `position_s` now.
  // Sequence numbers go on. INVALID_ARGUMENT outside [0, duration].
  absl::Status Seek(double position_s);
  // From the first frame to the last, at the recording's own speed.
  double duration_s() const { return times_s_.back(); }
  const dataset::Dataset& dataset() const { return dataset_; }
  // Which frame of the data set was exposure `sequence`: its name and its true
  // pose are in dataset().frame(). -1 for numbers that were not handed over.
  int DatasetFrameOf(int64_t sequence) const;

 private:
  // A run through the recording without a break: begun by Create and Seek.
  struct Run {
    int64_t first_sequence = 0;
    int first_frame = 0;
    double begin_s = 0;
    base::MonotonicTime start;
  };
  struct Decoded {
    int64_t sequence = 0;
    absl::StatusOr<image::Frame> frame;
  };

  ReplayCamera(const ReplayCameraOptions& options, dataset::Dataset dataset,
               std::vector<double> times_s, const base::Clock& clock);

  void DecodeAhead(const std::stop_token& stop);
  void Begin(double position_s, int64_t sequence)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Of frame `sequence` of the latest run.
  int FrameOf(const Run& run, int64_t sequence) const;
  base::MonotonicTime StampOf(const Run& run, int64_t sequence) const;
  // Whether the latest run has such a frame.
  bool Exists(const Run& run, int64_t sequence) const;
  bool MayDecode() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SkipTo(int64_t sequence) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void HandOver(Decoded decoded, std::vector<core::RgbdFrame>& frames)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ReplayCameraOptions options_;
  const dataset::Dataset dataset_;
  const std::vector<double> times_s_;
  // From the last frame to the first of the next round.
  const double round_gap_s_;
  const base::Clock& clock_;

  // Held by those who change what is to be handed over next.
  absl::Mutex take_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  mutable absl::Mutex mutex_;
  std::vector<Run> runs_ ABSL_GUARDED_BY(mutex_);
  // The next to hand over, and to decode; in between is what was decoded.
  int64_t next_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t next_to_decode_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<Decoded> ahead_ ABSL_GUARDED_BY(mutex_);
  // Counts jumps, so that what was being decoded meanwhile is thrown away.
  int64_t jumps_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  core::DeviceHealth health_ ABSL_GUARDED_BY(mutex_);
  std::jthread thread_;
};

}  // namespace treeline::replay_camera

#endif  // NAV_AGENT_DRIVERS_CAMERA_REPLAY_REPLAY_CAMERA_H_

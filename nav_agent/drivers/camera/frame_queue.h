// What every camera does with its frames: keep the latest, and count.
#ifndef NAV_AGENT_DRIVERS_CAMERA_FRAME_QUEUE_H_
#define NAV_AGENT_DRIVERS_CAMERA_FRAME_QUEUE_H_

#include <cstdint>
#include <deque>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/core/devices.h"

namespace treeline::camera_driver {

// Thread-safe.
class FrameQueue {
 public:
  // max_waiting: from 1 to kMaxWaiting; the oldest frames beyond are dropped.
  explicit FrameQueue(int max_waiting) : max_waiting_(max_waiting) {}

  // A good frame has come: the camera runs.
  void Push(core::RgbdFrame frame);
  // A frame has come broken, or only half of it has.
  void CountCorrupt(int64_t frames = 1);
  // Frames that were given up unseen.
  void CountDropped(int64_t frames);
  // The camera is not there, or not any longer. A loss is counted if it ran.
  void SetLost(const absl::Status& cause);

  std::vector<core::RgbdFrame> Take();
  core::DeviceHealth Health() const;

 private:
  const int max_waiting_;
  mutable absl::Mutex mutex_;
  std::deque<core::RgbdFrame> frames_ ABSL_GUARDED_BY(mutex_);
  core::DeviceHealth health_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::camera_driver

#endif  // NAV_AGENT_DRIVERS_CAMERA_FRAME_QUEUE_H_

#include "nav_agent/drivers/camera/frame_queue.h"

#include <iterator>
#include <utility>

namespace treeline::camera_driver {

void FrameQueue::Push(core::RgbdFrame frame) {
  absl::MutexLock lock(&mutex_);
  health_.state = core::DeviceState::kRunning;
  health_.cause = absl::OkStatus();
  ++health_.received;
  if (frames_.size() >= static_cast<size_t>(max_waiting_)) {
    frames_.pop_front();
    ++health_.dropped;
  }
  frames_.push_back(std::move(frame));
}

void FrameQueue::CountCorrupt(int64_t frames) {
  absl::MutexLock lock(&mutex_);
  health_.corrupt += frames;
}

void FrameQueue::CountDropped(int64_t frames) {
  absl::MutexLock lock(&mutex_);
  health_.dropped += frames;
}

void FrameQueue::SetLost(const absl::Status& cause) {
  absl::MutexLock lock(&mutex_);
  if (health_.state == core::DeviceState::kRunning) {
    health_.state = core::DeviceState::kLost;
    ++health_.losses;
  }
  health_.cause = cause;
}

std::vector<core::RgbdFrame> FrameQueue::Take() {
  absl::MutexLock lock(&mutex_);
  std::vector<core::RgbdFrame> frames(std::make_move_iterator(frames_.begin()),
                                      std::make_move_iterator(frames_.end()));
  frames_.clear();
  return frames;
}

core::DeviceHealth FrameQueue::Health() const {
  absl::MutexLock lock(&mutex_);
  return health_;
}

}  // namespace treeline::camera_driver

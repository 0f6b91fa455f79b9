#include "simulation/simulator/simulated_devices.h"

#include <algorithm>
#include <cmath>

#include "simulation/simulator/sim_event.h"

namespace treeline::simulator {

absl::Status SimulatedBase::SetVelocity(const core::VelocityCommand& command) {
  const SimTime now = clock_->now();
  const absl::MutexLock lock(&mutex_);
  if (!std::isfinite(command.forward_mps) ||
      !std::isfinite(command.yaw_rate_radps)) {
    command_ = {};
    ++health_.corrupt;
    return absl::InvalidArgumentError("a velocity command is not finite");
  }
  if (is_lost_) return health_.cause;
  command_ = command;
  given_ = now;
  ++health_.received;
  return absl::OkStatus();
}

void SimulatedBase::Stop() {
  const absl::MutexLock lock(&mutex_);
  command_ = {};
}

core::DeviceHealth SimulatedBase::Health() const {
  const absl::MutexLock lock(&mutex_);
  return health_;
}

core::VelocityCommand SimulatedBase::CommandAt(SimTime time) const {
  const absl::MutexLock lock(&mutex_);
  const bool too_old = time - given_ >= FromSeconds(kCommandLifetime_s);
  return too_old || is_lost_ ? core::VelocityCommand{} : command_;
}

void SimulatedBase::SetLost(bool is_lost) {
  const absl::MutexLock lock(&mutex_);
  if (is_lost && !is_lost_) ++health_.losses;
  if (is_lost) command_ = {};
  is_lost_ = is_lost;
  health_.state =
      is_lost ? core::DeviceState::kLost : core::DeviceState::kRunning;
  health_.cause =
      is_lost
          ? absl::UnavailableError("the base does not answer (simulated fault)")
          : absl::OkStatus();
}

camera::RgbdCalibration SimulatedCamera::Calibration() const {
  return imager_ == nullptr ? camera::RgbdCalibration{}
                            : imager_->Calibration();
}

core::RgbdFrame SimulatedCamera::Render(const Exposure& exposure) const {
  core::RgbdFrame frame = {.stamp = exposure.stamp,
                           .sequence = exposure.sequence,
                           .frame = imager_->Capture(exposure.shot)};
  if (exposure.dark) std::ranges::fill(frame.frame.color.rgb, uint8_t{0});
  if (exposure.blind && frame.frame.depth.has_value()) {
    std::ranges::fill(frame.frame.depth->values, uint16_t{0});
  }
  return frame;
}

std::vector<core::RgbdFrame> SimulatedCamera::TakeFrames() {
  std::vector<core::RgbdFrame> frames;
  if (imager_ == nullptr) return frames;
  for (const Exposure& exposure : queue.Take()) {
    frames.push_back(Render(exposure));
  }
  return frames;
}

std::vector<core::RgbdFrame> SimulatedCamera::TakeNewest() {
  if (imager_ == nullptr) return {};
  const std::vector<Exposure> exposures = queue.Take();
  if (exposures.empty()) return {};
  return {Render(exposures.back())};
}

const char* SimEventName(SimEventKind kind) {
  switch (kind) {
    case SimEventKind::kCollision:
      return "collision";
    case SimEventKind::kFall:
      return "fall";
    case SimEventKind::kStairs:
      return "stairs";
    case SimEventKind::kTipped:
      return "tipped";
    case SimEventKind::kSteep:
      return "steep";
    case SimEventKind::kPlaced:
      return "placed";
    case SimEventKind::kFaultBegan:
      return "fault began";
    case SimEventKind::kFaultEnded:
      return "fault ended";
    case SimEventKind::kObstacle:
      return "obstacle";
    case SimEventKind::kOdometryReset:
      return "odometry reset";
    case SimEventKind::kScenario:
      return "scenario";
  }
  return "unknown";
}

}  // namespace treeline::simulator

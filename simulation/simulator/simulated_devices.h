// The simulator's side of the ports: queues that its steps fill and that an
// agent empties, from any thread.
#ifndef SIMULATION_SIMULATOR_SIMULATED_DEVICES_H_
#define SIMULATION_SIMULATOR_SIMULATED_DEVICES_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"
#include "simulation/simulator/fault.h"
#include "simulation/worlds/world.h"

namespace treeline::simulator {

// Simulated time as the agent's clock has it: the simulation begins at
// MonotonicTime{}. Thread-safe.
class SimClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return StampOf(now()); }
  SimTime now() const { return SimTime(now_ns_.load()); }
  void Set(SimTime now) { now_ns_.store(now.count()); }

  static base::MonotonicTime StampOf(SimTime time) {
    return base::MonotonicTime(
        std::chrono::duration_cast<base::MonotonicTime::duration>(time));
  }

 private:
  std::atomic<int64_t> now_ns_{0};
};

// Measurements on their way to whoever takes them.
template <typename T>
class DeliveryQueue {
 public:
  explicit DeliveryQueue(const SimClock& clock) : clock_(&clock) {}

  void Push(SimTime arrival, T item) {
    const absl::MutexLock lock(&mutex_);
    waiting_.push_back({arrival, std::move(item)});
    ++health_.received;
    health_.state = core::DeviceState::kRunning;
    health_.cause = absl::OkStatus();
    if (waiting_.size() > static_cast<size_t>(core::kMaxWaiting)) {
      waiting_.pop_front();
      ++health_.dropped;
    }
  }

  // What has arrived by now, oldest first.
  std::vector<T> Take() {
    const SimTime now = clock_->now();
    const absl::MutexLock lock(&mutex_);
    std::vector<T> taken;
    while (!waiting_.empty() && waiting_.front().arrival <= now) {
      taken.push_back(std::move(waiting_.front().item));
      waiting_.pop_front();
    }
    return taken;
  }

  void SetLost(const absl::Status& cause) {
    const absl::MutexLock lock(&mutex_);
    if (health_.state != core::DeviceState::kLost) ++health_.losses;
    health_.state = core::DeviceState::kLost;
    health_.cause = cause;
  }
  void SetRunning() {
    const absl::MutexLock lock(&mutex_);
    health_.state = core::DeviceState::kRunning;
    health_.cause = absl::OkStatus();
  }

  core::DeviceHealth Health() const {
    const absl::MutexLock lock(&mutex_);
    return health_;
  }

 private:
  struct Waiting {
    SimTime arrival;
    T item;
  };

  const SimClock* clock_;
  mutable absl::Mutex mutex_;
  std::deque<Waiting> waiting_ ABSL_GUARDED_BY(mutex_);
  core::DeviceHealth health_ ABSL_GUARDED_BY(mutex_);
};

class SimulatedLaser final : public core::RangeSensor {
 public:
  SimulatedLaser(const SimClock& clock, const core::RangeSensorInfo& info)
      : queue(clock), info_(info) {}
  core::RangeSensorInfo Info() const override { return info_; }
  std::vector<core::LaserScan> TakeScans() override { return queue.Take(); }
  core::DeviceHealth Health() const override { return queue.Health(); }

  DeliveryQueue<core::LaserScan> queue;

 private:
  const core::RangeSensorInfo info_;
};

class SimulatedOdometry final : public core::Odometry {
 public:
  explicit SimulatedOdometry(const SimClock& clock) : queue(clock) {}
  std::vector<core::BaseReading> TakeReadings() override {
    return queue.Take();
  }
  core::DeviceHealth Health() const override { return queue.Health(); }

  DeliveryQueue<core::BaseReading> queue;
};

class SimulatedBase final : public core::BaseDriver {
 public:
  explicit SimulatedBase(const SimClock& clock) : clock_(&clock) {
    health_.state = core::DeviceState::kRunning;
  }
  absl::Status SetVelocity(const core::VelocityCommand& command) override;
  void Stop() override;
  core::DeviceHealth Health() const override;

  // What the base obeys at a moment: nothing that is older than
  // kCommandLifetime_s.
  core::VelocityCommand CommandAt(SimTime time) const;
  void SetLost(bool is_lost);

 private:
  const SimClock* clock_;
  mutable absl::Mutex mutex_;
  core::VelocityCommand command_ ABSL_GUARDED_BY(mutex_);
  SimTime given_ ABSL_GUARDED_BY(mutex_){0};
  bool is_lost_ ABSL_GUARDED_BY(mutex_) = false;
  core::DeviceHealth health_ ABSL_GUARDED_BY(mutex_);
};

// What is to be seen in one exposure.
struct CameraShot {
  // The pose sensor, in the middle of the exposure.
  geometry::Rigid3 world_from_camera;
  std::vector<worlds::BodyInstance> bodies;
  int64_t sequence = 0;
};

// Makes the pictures. Thread-safe; the result depends on the shot alone.
class Imager {
 public:
  virtual ~Imager() = default;
  virtual camera::RgbdCalibration Calibration() const = 0;
  virtual image::Frame Capture(const CameraShot& shot) const = 0;
};

// Takes no pictures until somebody asks for them: TakeFrames renders what is
// waiting, in the thread that asks.
class SimulatedCamera final : public core::RgbdCamera {
 public:
  // An exposure that waits to be rendered.
  struct Exposure {
    base::MonotonicTime stamp;
    int64_t sequence = 0;
    CameraShot shot;
    bool dark = false;
    bool blind = false;
  };

  // A null imager: there is no camera, and no frame ever.
  SimulatedCamera(const SimClock& clock, std::shared_ptr<const Imager> imager)
      : queue(clock), imager_(std::move(imager)) {}
  camera::RgbdCalibration Calibration() const override;
  std::vector<core::RgbdFrame> TakeFrames() override;
  // Only the newest that has arrived: the others are never rendered.
  std::vector<core::RgbdFrame> TakeNewest();
  core::DeviceHealth Health() const override { return queue.Health(); }

  DeliveryQueue<Exposure> queue;

 private:
  core::RgbdFrame Render(const Exposure& exposure) const;

  const std::shared_ptr<const Imager> imager_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SIMULATED_DEVICES_H_

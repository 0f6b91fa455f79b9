// A simulated robot whose laser and base are played byte for byte: what drives
// it through real drivers drives it through a world.
#ifndef NAV_AGENT_EMULATORS_SIMULATED_ROBOT_H_
#define NAV_AGENT_EMULATORS_SIMULATED_ROBOT_H_

#include <cstdint>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/synthetic/laser_scanner.h"
#include "nav_agent/emulators/base_plant.h"
#include "nav_agent/emulators/laser_source.h"
#include "nav_agent/sim/simulator.h"

namespace treeline {

// The source of an emulated laser, and the plant of an emulated base, in one
// simulation. Simulated time follows the time that the emulators ask for, so
// that a clock that runs k times as fast makes a world that does. Thread-safe:
// each emulator has its own thread.
class SimulatedRobot final : public LaserSource, public BasePlant {
 public:
  // Simulated time 0 is `start` for the emulators. The simulator must outlive
  // this, and be stepped by nobody else.
  static absl::StatusOr<std::unique_ptr<SimulatedRobot>> Create(
      Simulator& simulator, MonotonicTime start);

  // The scanner's beams are those of the simulator's laser, and `info` must
  // have as many.
  LaserScan ScanAt(MonotonicTime start, const RangeSensorInfo& info) override {
    return ScanFrom(LaserMount::kFront, start, info);
  }
  // The same scanner, that looks back.
  LaserSource& rear_laser() { return rear_laser_; }
  BasePlantState Step(const VelocityCommand& wanted,
                      double interval_s) override;

 private:
  class RearLaser final : public LaserSource {
   public:
    explicit RearLaser(SimulatedRobot& robot) : robot_(robot) {}
    LaserScan ScanAt(MonotonicTime start,
                     const RangeSensorInfo& info) override {
      return robot_.ScanFrom(LaserMount::kRear, start, info);
    }

   private:
    SimulatedRobot& robot_;
  };

  SimulatedRobot(Simulator& simulator, LaserScanner scanner,
                 MonotonicTime start)
      : simulator_(simulator),
        scanner_(std::move(scanner)),
        start_(start),
        rear_laser_(*this) {}
  LaserScan ScanFrom(LaserMount mount, MonotonicTime start,
                     const RangeSensorInfo& info);
  void AdvanceTo(SimTime time) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Simulator& simulator_;
  const LaserScanner scanner_;
  const MonotonicTime start_;
  RearLaser rear_laser_;
  absl::Mutex mutex_;
  int64_t scans_ ABSL_GUARDED_BY(mutex_) = 0;
  // Until when the base has been stepped.
  SimTime base_time_ ABSL_GUARDED_BY(mutex_){0};
  BasePlantState state_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline

#endif  // NAV_AGENT_EMULATORS_SIMULATED_ROBOT_H_

// A simulated robot whose laser and base are played byte for byte: what drives
// it through real drivers drives it through a world.
#ifndef SIMULATION_EMULATORS_SIMULATED_ROBOT_H_
#define SIMULATION_EMULATORS_SIMULATED_ROBOT_H_

#include <cstdint>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "simulation/emulators/base_plant.h"
#include "simulation/emulators/laser_source.h"
#include "simulation/sensors/laser_scanner.h"
#include "simulation/simulator/simulator.h"

namespace treeline::emulators {

// The source of an emulated laser, and the plant of an emulated base, in one
// simulation. Simulated time follows the time that the emulators ask for, so
// that a clock that runs k times as fast makes a world that does. Thread-safe:
// each emulator has its own thread.
class SimulatedRobot final : public LaserSource, public BasePlant {
 public:
  // Simulated time 0 is `start` for the emulators. The simulator must outlive
  // this, and be stepped by nobody else.
  static absl::StatusOr<std::unique_ptr<SimulatedRobot>> Create(
      simulator::Simulator& simulator, base::MonotonicTime start);

  // The scanner's beams are those of the simulator's laser, and `info` must
  // have as many.
  core::LaserScan ScanAt(base::MonotonicTime start,
                         const core::RangeSensorInfo& info) override {
    return ScanFrom(core::LaserMount::kFront, start, info);
  }
  // The same scanner, that looks back.
  LaserSource& rear_laser() { return rear_laser_; }
  BasePlantState Step(const core::VelocityCommand& wanted,
                      double interval_s) override;

 private:
  class RearLaser final : public LaserSource {
   public:
    explicit RearLaser(SimulatedRobot& robot) : robot_(robot) {}
    core::LaserScan ScanAt(base::MonotonicTime start,
                           const core::RangeSensorInfo& info) override {
      return robot_.ScanFrom(core::LaserMount::kRear, start, info);
    }

   private:
    SimulatedRobot& robot_;
  };

  SimulatedRobot(simulator::Simulator& simulator, sensors::LaserScanner scanner,
                 base::MonotonicTime start)
      : simulator_(simulator),
        scanner_(std::move(scanner)),
        start_(start),
        rear_laser_(*this) {}
  core::LaserScan ScanFrom(core::LaserMount mount, base::MonotonicTime start,
                           const core::RangeSensorInfo& info);
  void AdvanceTo(simulator::SimTime time) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  simulator::Simulator& simulator_;
  const sensors::LaserScanner scanner_;
  const base::MonotonicTime start_;
  RearLaser rear_laser_;
  absl::Mutex mutex_;
  int64_t scans_ ABSL_GUARDED_BY(mutex_) = 0;
  // Until when the base has been stepped.
  simulator::SimTime base_time_ ABSL_GUARDED_BY(mutex_){0};
  BasePlantState state_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_SIMULATED_ROBOT_H_

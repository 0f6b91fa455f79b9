// What a robot's sensors measure on its way, and when it arrives.
#ifndef SIMULATION_SIMULATOR_SENSOR_SUITE_H_
#define SIMULATION_SIMULATOR_SENSOR_SUITE_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "simulation/sensors/laser_scanner.h"
#include "simulation/simulator/fault.h"
#include "simulation/simulator/robot_body.h"
#include "simulation/simulator/simulated_devices.h"
#include "simulation/simulator/stage.h"

namespace treeline::simulator {

struct SensorOptions {
  // From the end of a measurement until it can be taken, in [0, 10] s.
  double laser_latency_s = 0.005;
  double odometry_latency_s = 0.002;
  double camera_latency_s = 0.04;
  bool has_laser = true;
  sensors::LaserScannerOptions laser;
  // One that looks back, beside the first one.
  bool has_rear_laser = false;
  sensors::LaserScannerOptions rear_laser = ShortRangeLaser();
  // Readings and frames in a second. In [1, 200]; [0, 60], 0: no camera.
  double odometry_hz = 100;
  double camera_hz = 0;
  // Pictures are 640 x 480 pixels times this; smaller ones take less time. In
  // [0.1, 1].
  double camera_scale = 1;
  // Whether the world's light is prepared (a second or two) for the pictures'
  // colours; else it is that of a cloudy day everywhere. Depth is the same.
  bool camera_is_lit = true;

  // These lasers, with the noise of those that are set.
  void UseLasers(const core::RobotLasers& lasers);

  // A Hokuyo UST-10LX (data sheet C-42-4057: 10 m, 40 mm) of which every second
  // beam is read.
  static sensors::LaserScannerOptions ShortRangeLaser();
  absl::Status Validate() const;
};

// Where the robot was in the last half second.
class PoseHistory {
 public:
  void Add(SimTime time, const geometry::Rigid3& world_from_base);
  // Forgets: the robot was put elsewhere.
  void Restart(SimTime time, const geometry::Rigid3& world_from_base);
  // In between, it moved evenly; before and after, it stood.
  geometry::Rigid3 At(SimTime time) const;

 private:
  struct Entry {
    SimTime time;
    geometry::Rigid3 world_from_base;
  };
  std::deque<Entry> entries_;
};

// Not thread-safe; the devices are.
class SensorSuite {
 public:
  // What is given must outlive it, but for the imager.
  static absl::StatusOr<std::unique_ptr<SensorSuite>> Create(
      const worlds::World& world, const renderer::RayCaster& caster,
      const core::RobotModel& robot, const WheelOdometryErrors& errors,
      const SensorOptions& options, uint64_t seed, const SimClock& clock,
      std::shared_ptr<const Imager> imager);

  // Everything that is measured up to `now`, the end of a step of the body.
  void Step(const RobotBody& body, const Stage& stage, const FaultPlan& faults,
            SimTime now);
  void Restart(const RobotBody& body, SimTime now);

  const PoseHistory& history() const { return history_; }
  SimulatedLaser& laser() { return front_->device; }
  SimulatedLaser* rear_laser() {
    return rear_ == nullptr ? nullptr : &rear_->device;
  }
  SimulatedOdometry& odometry() { return odometry_; }
  SimulatedCamera& camera() { return camera_; }

 private:
  // A laser of the robot.
  struct Laser {
    Laser(core::LaserMount on, FaultTarget of, sensors::LaserScanner measured,
          const SimClock& clock);

    core::LaserMount mount;
    FaultTarget target;
    sensors::LaserScanner scanner;
    SimulatedLaser device;
    // How many were due so far, lost ones too: they number the noise.
    int64_t scans = 0;
    // What a frozen one repeats.
    std::optional<core::LaserScan> last;
  };

  SensorSuite(const core::RobotModel& robot, const renderer::RayCaster& caster,
              const WheelOdometryErrors& errors, const SensorOptions& options,
              uint64_t seed, const SimClock& clock,
              std::shared_ptr<const Imager> imager);
  void MeasureOdometry(const RobotBody& body, const FaultPlan& faults,
                       SimTime now);
  void ScanUntil(const Stage& stage, const FaultPlan& faults, SimTime now,
                 Laser& laser);
  void ScanOnce(const Stage& stage, const FaultPlan& faults, SimTime first,
                Laser& laser);
  void ExposeOnce(const Stage& stage, const FaultPlan& faults, SimTime middle);

  core::RobotModel robot_;
  const renderer::RayCaster* caster_;
  InertialSensor inertial_;
  SensorOptions options_;
  uint64_t seed_;
  bool has_camera_;
  PoseHistory history_;
  std::unique_ptr<Laser> front_;
  std::unique_ptr<Laser> rear_;
  SimulatedOdometry odometry_;
  SimulatedCamera camera_;
  // How many were due so far, lost ones too: they number the noise.
  int64_t readings_ = 0;
  int64_t exposures_ = 0;
  // What a frozen device repeats.
  std::optional<core::BaseReading> last_reading_;
  std::optional<SimulatedCamera::Exposure> last_exposure_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SENSOR_SUITE_H_

// What a robot's sensors measure on its way, and when it arrives.
#ifndef NAV_AGENT_SIM_SENSOR_SUITE_H_
#define NAV_AGENT_SIM_SENSOR_SUITE_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "common/synthetic/laser_scanner.h"
#include "nav_agent/sim/fault.h"
#include "nav_agent/sim/robot_body.h"
#include "nav_agent/sim/simulated_devices.h"
#include "nav_agent/sim/stage.h"

namespace treeline {

struct SensorOptions {
  // From the end of a measurement until it can be taken, in [0, 10] s.
  double laser_latency_s = 0.005;
  double odometry_latency_s = 0.002;
  double camera_latency_s = 0.04;
  bool has_laser = true;
  LaserScannerOptions laser;
  // One that looks back, beside the first one.
  bool has_rear_laser = false;
  LaserScannerOptions rear_laser = ShortRangeLaser();
  // Readings and frames in a second. In [1, 200]; [0, 60], 0: no camera.
  double odometry_hz = 100;
  double camera_hz = 0;
  // Pictures are 640 x 480 pixels times this; smaller ones take less time. In
  // [0.1, 1].
  double camera_scale = 1;
  // Whether the world's light is prepared (a second or two) for the pictures'
  // colours; else it is that of a cloudy day everywhere. Depth is the same.
  bool camera_is_lit = true;

  // A Hokuyo UST-10LX (data sheet C-42-4057: 10 m, 40 mm) of which every second
  // beam is read.
  static LaserScannerOptions ShortRangeLaser();
  absl::Status Validate() const;
};

// Where the robot was in the last half second.
class PoseHistory {
 public:
  void Add(SimTime time, const Rigid3& world_from_base);
  // Forgets: the robot was put elsewhere.
  void Restart(SimTime time, const Rigid3& world_from_base);
  // In between, it moved evenly; before and after, it stood.
  Rigid3 At(SimTime time) const;

 private:
  struct Entry {
    SimTime time;
    Rigid3 world_from_base;
  };
  std::deque<Entry> entries_;
};

// Not thread-safe; the devices are.
class SensorSuite {
 public:
  // What is given must outlive it, but for the imager.
  static absl::StatusOr<std::unique_ptr<SensorSuite>> Create(
      const World& world, const RayCaster& caster, const RobotModel& robot,
      const DriveErrors& errors, const SensorOptions& options, uint64_t seed,
      const SimClock& clock, std::shared_ptr<const Imager> imager);

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
    Laser(LaserMount on, FaultTarget of, LaserScanner measured,
          const SimClock& clock);

    LaserMount mount;
    FaultTarget target;
    LaserScanner scanner;
    SimulatedLaser device;
    // How many were due so far, lost ones too: they number the noise.
    int64_t scans = 0;
    // What a frozen one repeats.
    std::optional<LaserScan> last;
  };

  SensorSuite(const RobotModel& robot, const RayCaster& caster,
              const DriveErrors& errors, const SensorOptions& options,
              uint64_t seed, const SimClock& clock,
              std::shared_ptr<const Imager> imager);
  void MeasureOdometry(const RobotBody& body, const FaultPlan& faults,
                       SimTime now);
  void ScanUntil(const Stage& stage, const FaultPlan& faults, SimTime now,
                 Laser& laser);
  void ScanOnce(const Stage& stage, const FaultPlan& faults, SimTime first,
                Laser& laser);
  void ExposeOnce(const Stage& stage, const FaultPlan& faults, SimTime middle);

  RobotModel robot_;
  const RayCaster* caster_;
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
  std::optional<BaseReading> last_reading_;
  std::optional<SimulatedCamera::Exposure> last_exposure_;
};

}  // namespace treeline

#endif  // NAV_AGENT_SIM_SENSOR_SUITE_H_

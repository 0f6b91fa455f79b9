// A robot's laser and wheels as its calibration corrects them.
#ifndef NAV_AGENT_CORE_CORRECTED_DEVICES_H_
#define NAV_AGENT_CORE_CORRECTED_DEVICES_H_

#include <chrono>
#include <vector>

#include "nav_agent/core/devices.h"
#include "nav_agent/core/robot_file.h"

namespace treeline::core {

// Wheels that roll as far as they truly do. `odometry` must outlive it.
class CorrectedOdometry final : public Odometry {
 public:
  CorrectedOdometry(Odometry& odometry, const SensorCorrection& correction)
      : odometry_(odometry), correction_(correction) {}

  std::vector<BaseReading> TakeReadings() override {
    std::vector<BaseReading> readings = odometry_.TakeReadings();
    for (BaseReading& reading : readings) {
      reading.left_wheel_m *= correction_.left_scale;
      reading.right_wheel_m *= correction_.right_scale;
    }
    return readings;
  }
  DeviceHealth Health() const override { return odometry_.Health(); }

 private:
  Odometry& odometry_;
  const SensorCorrection correction_;
};

// Scans with stamps on the wheels' time. `laser` must outlive it.
class CorrectedLaser final : public RangeSensor {
 public:
  CorrectedLaser(RangeSensor& laser, const SensorCorrection& correction)
      : laser_(laser),
        delay_(std::chrono::duration_cast<base::MonotonicTime::duration>(
            std::chrono::duration<double>(correction.laser_delay_s))) {}

  RangeSensorInfo Info() const override { return laser_.Info(); }
  std::vector<LaserScan> TakeScans() override {
    std::vector<LaserScan> scans = laser_.TakeScans();
    for (LaserScan& scan : scans) scan.stamp -= delay_;
    return scans;
  }
  DeviceHealth Health() const override { return laser_.Health(); }

 private:
  RangeSensor& laser_;
  const base::MonotonicTime::duration delay_;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_CORRECTED_DEVICES_H_

// A robot's laser, wheels and camera as its calibration corrects them.
#ifndef NAV_AGENT_CORE_CORRECTED_DEVICES_H_
#define NAV_AGENT_CORE_CORRECTED_DEVICES_H_

#include <chrono>
#include <vector>

#include "nav_agent/core/devices.h"
#include "nav_agent/core/robot_file.h"

namespace treeline::core {

// One measurement as it is to be understood.
inline void Correct(const SensorCorrection& correction, BaseReading& reading) {
  const double left_m = correction.left_scale * reading.left_wheel_m;
  const double right_m = correction.right_scale * reading.right_wheel_m;
  const double way_m = (left_m + right_m) / 2;
  const double half_turn_m = correction.turn_scale * (right_m - left_m) / 2;
  reading.left_wheel_m = way_m - half_turn_m;
  reading.right_wheel_m = way_m + half_turn_m;
  reading.yaw_rate_radps *= correction.turn_scale;
}

inline base::MonotonicTime::duration DelayOf(double seconds) {
  return std::chrono::duration_cast<base::MonotonicTime::duration>(
      std::chrono::duration<double>(seconds));
}

// Wheels that roll as far as they truly do. `odometry` must outlive it.
class CorrectedOdometry final : public Odometry {
 public:
  CorrectedOdometry(Odometry& odometry, const SensorCorrection& correction)
      : odometry_(odometry), correction_(correction) {}

  std::vector<BaseReading> TakeReadings() override {
    std::vector<BaseReading> readings = odometry_.TakeReadings();
    for (BaseReading& reading : readings) Correct(correction_, reading);
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
      : laser_(laser), delay_(DelayOf(correction.laser_delay_s)) {}

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

// Likewise pictures. `camera` must outlive it.
class CorrectedCamera final : public RgbdCamera {
 public:
  CorrectedCamera(RgbdCamera& camera, const SensorCorrection& correction)
      : camera_(camera), delay_(DelayOf(correction.camera_delay_s)) {}

  camera::RgbdCalibration Calibration() const override {
    return camera_.Calibration();
  }
  std::vector<RgbdFrame> TakeFrames() override {
    std::vector<RgbdFrame> frames = camera_.TakeFrames();
    for (RgbdFrame& frame : frames) frame.stamp -= delay_;
    return frames;
  }
  DeviceHealth Health() const override { return camera_.Health(); }

 private:
  RgbdCamera& camera_;
  const base::MonotonicTime::duration delay_;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_CORRECTED_DEVICES_H_

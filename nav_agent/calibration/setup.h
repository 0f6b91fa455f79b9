// The numbers that a calibration is about.
#ifndef NAV_AGENT_CALIBRATION_SETUP_H_
#define NAV_AGENT_CALIBRATION_SETUP_H_

#include <optional>

#include "common/geometry/rigid2.h"
#include "nav_agent/calibration/wheel_path.h"
#include "nav_agent/core/odometry_noise.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::calibration {

// What a robot's readings are to be understood with.
struct Setup {
  Wheels wheels;
  geometry::Rigid2 base_from_laser;
  // Scans are stamped this much later than wheel readings of the same moment.
  double laser_delay_s = 0;
  // Of the wheels as they are then understood; nullopt: nobody measured it.
  std::optional<core::MeasuredOdometryNoise> noise{};
};

// The numbers of a Setup, in this order.
enum class Quantity {
  kLeftScale,
  kRightScale,
  kTrack,
  kLaserX,
  kLaserY,
  kLaserYaw,
  kLaserDelay
};
inline constexpr int kQuantities = 7;
double ValueOf(const Setup& setup, Quantity quantity);
void SetValue(Setup& setup, Quantity quantity, double value);
// "left wheel", "track"; "", "m", "rad", "s".
const char* NameOf(Quantity quantity);
const char* UnitOf(Quantity quantity);
// How to drive so that it becomes known.
const char* DriveFor(Quantity quantity);

// As a recording describes its robot.
Setup AssumedSetup(const core::RobotModel& robot);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_SETUP_H_

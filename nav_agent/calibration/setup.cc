#include "nav_agent/calibration/setup.h"

#include "common/geometry/planar_pose.h"

namespace treeline::calibration {

double ValueOf(const Setup& setup, Quantity quantity) {
  switch (quantity) {
    case Quantity::kLeftScale:
      return setup.wheels.left_scale;
    case Quantity::kRightScale:
      return setup.wheels.right_scale;
    case Quantity::kTrack:
      return setup.wheels.track_m;
    case Quantity::kLaserX:
      return setup.base_from_laser.translation.x;
    case Quantity::kLaserY:
      return setup.base_from_laser.translation.y;
    case Quantity::kLaserYaw:
      return setup.base_from_laser.yaw_rad;
    case Quantity::kLaserDelay:
      return setup.laser_delay_s;
  }
  return 0;
}

void SetValue(Setup& setup, Quantity quantity, double value) {
  switch (quantity) {
    case Quantity::kLeftScale:
      setup.wheels.left_scale = value;
      return;
    case Quantity::kRightScale:
      setup.wheels.right_scale = value;
      return;
    case Quantity::kTrack:
      setup.wheels.track_m = value;
      return;
    case Quantity::kLaserX:
      setup.base_from_laser.translation.x = value;
      return;
    case Quantity::kLaserY:
      setup.base_from_laser.translation.y = value;
      return;
    case Quantity::kLaserYaw:
      setup.base_from_laser.yaw_rad = value;
      return;
    case Quantity::kLaserDelay:
      setup.laser_delay_s = value;
      return;
  }
}

const char* NameOf(Quantity quantity) {
  switch (quantity) {
    case Quantity::kLeftScale:
      return "left wheel";
    case Quantity::kRightScale:
      return "right wheel";
    case Quantity::kTrack:
      return "track";
    case Quantity::kLaserX:
      return "laser x";
    case Quantity::kLaserY:
      return "laser y";
    case Quantity::kLaserYaw:
      return "laser yaw";
    case Quantity::kLaserDelay:
      return "laser delay";
  }
  return "";
}

const char* UnitOf(Quantity quantity) {
  switch (quantity) {
    case Quantity::kLeftScale:
    case Quantity::kRightScale:
      return "";
    case Quantity::kTrack:
    case Quantity::kLaserX:
    case Quantity::kLaserY:
      return "m";
    case Quantity::kLaserYaw:
      return "rad";
    case Quantity::kLaserDelay:
      return "s";
  }
  return "";
}

const char* DriveFor(Quantity quantity) {
  switch (quantity) {
    case Quantity::kLeftScale:
    case Quantity::kRightScale:
      return "drive straight ahead for 20 m, and a circle or two each way";
    case Quantity::kTrack:
    case Quantity::kLaserX:
    case Quantity::kLaserY:
      return "turn on the spot, a few whole turns each way";
    case Quantity::kLaserYaw:
      return "drive straight ahead for 20 m";
    case Quantity::kLaserDelay:
      return "begin and end turns: twenty quick ones, left and right";
  }
  return "";
}

Setup AssumedSetup(const core::RobotModel& robot) {
  return {.wheels = {.track_m = robot.wheel_track_m},
          .base_from_laser = geometry::PlanarPose(robot.base_from_laser)};
}

}  // namespace treeline::calibration

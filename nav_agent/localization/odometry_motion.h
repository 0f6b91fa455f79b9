// How a robot may have moved when its wheels say that it moved so.
#ifndef NAV_AGENT_LOCALIZATION_ODOMETRY_MOTION_H_
#define NAV_AGENT_LOCALIZATION_ODOMETRY_MOTION_H_

#include "absl/status/status.h"
#include "common/base/random.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/odometry_noise.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {

// The odometry motion model (Thrun, Burgard, Fox, Probabilistic Robotics, 2005,
// table 5.6): a motion is a turn, a straight way and another turn, whose
// standard deviations are sums of these shares of the three. Defaults suit a
// differential drive on firm ground.
struct OdometryNoise {
  // Of a turn, from turning and from driving (rad per rad, rad per m).
  double turn_from_turn = kTurnFromTurn;
  double turn_from_drive = kTurnFromDrive;
  // Of the way, from driving and from turning (m per m, m per rad).
  double drive_from_drive = kDriveFromDrive;
  double drive_from_turn = kDriveFromTurn;

  // For a robot whose odometry was measured: kNoiseMargin of that, and no less
  // than usual.
  static OdometryNoise Of(const core::MeasuredOdometryNoise& measured);
  // Each share at least as large as the default.
  OdometryNoise AtLeastUsual() const;

  // INVALID_ARGUMENT for what is negative, above 10, or not a number.
  absl::Status Validate() const;
};

// One motion between two moments, prepared for many draws.
class OdometryMotion {
 public:
  // `before_from_after`: where odometry has the robot now in the frame of where
  // it was then.
  OdometryMotion(const geometry::Rigid2& before_from_after,
                 const OdometryNoise& noise);

  // A pose drawn for a robot that was at map_from_before.
  geometry::Rigid2 Sample(const geometry::Rigid2& map_from_before,
                          base::Random& random) const;

 private:
  double turn_before_rad_ = 0;
  // Back: less than 0.
  double drive_m_ = 0;
  double turn_after_rad_ = 0;
  double turn_before_sigma_rad_ = 0;
  double drive_sigma_m_ = 0;
  double turn_after_sigma_rad_ = 0;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_ODOMETRY_MOTION_H_

// Dead reckoning on uneven ground: wheels, yaw rate, pitch and roll to a pose
// in space, and to the way as a map sees it from above.
#ifndef NAV_AGENT_CORE_SLOPE_ODOMETRY_H_
#define NAV_AGENT_CORE_SLOPE_ODOMETRY_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::core {

struct SlopeOdometryOptions {
  // Of the robot that is driven: RobotModel::wheel_track_m (m, 0.05 to 10).
  double wheel_track_m = 0.54;
  // Ground that is flatter than this counts as level: the floors of buildings
  // are, and what the inertial sensor says there is its bias. Without it a bias
  // of 0.2 degrees is 0.35 m of height on 100 m of level floor. 0: every tilt
  // is used (rad, 0 to 0.2).
  double level_within_rad = 0.02;
  // How fast the bias follows on level ground, and how large it may be (s, rad,
  // above 0 and 0 to 0.2).
  double bias_time_s = 20;
  double max_bias_rad = 0.02;
  // Whether the yaw rate is used rather than the wheels, which slip; after
  // a silence of more than max_gap_s (s, above 0) the wheels are.
  bool uses_yaw_rate = true;
  double max_gap_s = 0.5;
  // Wheels that turned faster than this were not turned but their counters
  // reset: the robot is taken to have stood (m/s, above 0).
  double max_speed_mps = 3.0;

  absl::Status Validate() const;
};

// Between two readings the robot moves along an arc in the plane that it stands
// in, with the mean of both tilts. With the way s that the wheels rolled, the
// turn a about the base's z axis, pitch p (nose down is positive) and roll r:
//
//   odom_from_base = (Rz(yaw) Ry(p) Rx(r), position)
//   position += Rz(yaw) Ry(p) Rx(r) (c cos(a/2), c sin(a/2), 0),
//               c = s sin(a/2) / (a/2)
//
// so that, straight ahead, height grows by -sin(p) s and the way seen from
// above by cos(p) s. yaw is the direction of the x axis seen from above; it
// turns by more than `a` on a slope that the robot crosses. Position, height
// and yaw begin at 0. Deterministic; not thread-safe.
class SlopeOdometry {
 public:
  static absl::StatusOr<SlopeOdometry> Create(
      const SlopeOdometryOptions& options);

  // The next reading; the first only says where the wheels stand.
  // INVALID_ARGUMENT, and nothing is changed, if a number that is used is not
  // finite, if the robot would lie on its side (tilt beyond 1 rad), or if time
  // goes backwards.
  absl::Status Add(const BaseReading& reading);

  bool has_reading() const { return has_reading_; }
  base::MonotonicTime stamp() const { return last_.stamp; }

  // Where the robot is in space.
  geometry::Rigid3 OdomFromBase() const;
  // The same from above: distances are as a map has them, corrected for the
  // slope.
  geometry::Rigid2 PlanarOdomFromBase() const {
    return {.translation = {position_m_.x, position_m_.y}, .yaw_rad = yaw_rad_};
  }
  double height_m() const { return position_m_.z; }
  // Pitch and roll, without the inertial sensor's bias; yaw and translation 0.
  geometry::Rotation3 LevelFromBase() const;
  double pitch_rad() const { return pitch_.angle_rad; }
  double roll_rad() const { return roll_.angle_rad; }

  // The way that was rolled, back and forth added up.
  double way_m() const { return way_m_; }
  // How often counters were taken to have been reset.
  int64_t resets() const { return resets_; }

 private:
  // One angle of the inertial sensor.
  struct Tilt {
    double angle_rad = 0;
    double bias_rad = 0;
    int64_t level_readings = 0;
  };

  explicit SlopeOdometry(const SlopeOdometryOptions& options)
      : options_(options) {}
  void Follow(Tilt& tilt, double measured_rad, double interval_s) const;

  SlopeOdometryOptions options_;
  bool has_reading_ = false;
  BaseReading last_;
  geometry::Vec3 position_m_;
  double yaw_rad_ = 0;
  Tilt pitch_;
  Tilt roll_;
  double way_m_ = 0;
  int64_t resets_ = 0;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_SLOPE_ODOMETRY_H_

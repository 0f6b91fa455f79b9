// From velocity commands to how far a differential drive moves, and to what
// its sensors say of that.
#ifndef SIMULATION_SIMULATOR_DIFFERENTIAL_DRIVE_H_
#define SIMULATION_SIMULATOR_DIFFERENTIAL_DRIVE_H_

#include <cstdint>

#include "absl/status/status.h"
#include "nav_agent/core/odometry_noise.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::simulator {

// How a robot's wheels and inertial sensor err. Standard deviations; 0 is no
// error. Drawn once for a seed: radii, track, biases.
struct WheelOdometryErrors {
  // Of each wheel's radius and of the track, as shares of them.
  double wheel_radius = 0.003;
  double track = 0.01;
  // Noise of what each wheel's counter says, for one metre of way and for a
  // turn of one radian; it grows with the square root of both.
  double distance_m_per_sqrt_m = 0.004;
  double turn_m_per_sqrt_rad = 0.002;
  // Wheels slip this share of the way times the sine of the slope: uphill the
  // robot gets less far than they roll, downhill further.
  double slope_slip = 0.10;
  // On slopes steeper than 2 degrees one wheel at a time loses grip: so often
  // in a second of driving, for 0.1 to 0.4 s, by 20 to 60 % of its way.
  double slip_bursts_hz = 0.15;
  // Counts of a wheel's counter in a metre (RMP100: 40181); 0: exact.
  double counts_per_m = 40181;
  // Of pitch and roll: white noise, and a bias that wanders with a time
  // constant of five minutes.
  double tilt_noise_rad = 0.002;
  double tilt_bias_rad = 0.004;
  // Of the yaw rate: a share of it, and white noise.
  double yaw_rate_scale = 0.005;
  double yaw_rate_noise_radps = 0.003;

  // Counters' noise such that wheels alone, calibrated, err by this. What
  // wheels, track, slopes and the inertial sensor do stays.
  void UseNoise(const core::MeasuredOdometryNoise& noise, double track_m);

  // No errors at all.
  static WheelOdometryErrors None();
  absl::Status Validate() const;
};

// What faults do to the wheels.
struct WheelFaults {
  bool left_stuck = false;
  bool right_stuck = false;
  // Shares of their way that they slip, in [0, 1].
  double left_slip = 0;
  double right_slip = 0;
};

// One motion of the robot in its own plane: along an arc.
struct PlanarMotion {
  double forward_m = 0;
  double turn_rad = 0;
};

// Advances in fixed steps. All draws are functions of (seed, step).
class DifferentialDrive {
 public:
  static constexpr double kStep_s = 0.005;

  DifferentialDrive(const core::RobotModel& robot,
                    const WheelOdometryErrors& errors, uint64_t seed);

  // How the robot moves in step `step` when it is asked for `target` and
  // stands at this pitch and tilt. Speeds follow within the robot's limits of
  // speed and acceleration; on slopes gravity helps or hinders a quarter of
  // what it pulls.
  PlanarMotion Advance(const core::VelocityCommand& target, double pitch_rad,
                       double tilt_rad, const WheelFaults& faults,
                       int64_t step);
  // The motion that Advance returned has taken place: counters count.
  void Commit();
  // It could not: wheels stand.
  void Block();

  // Of the wheels, as if nothing slipped.
  double forward_mps() const { return forward_mps_; }
  double yaw_rate_radps() const { return yaw_rate_radps_; }

  // Everything but stamp and inertial sensor: counters as they stand.
  core::BaseReading Counters() const;
  void ResetCounters();

 private:
  void Accelerate(const core::VelocityCommand& target, double pitch_rad);
  void BeginSlipBurst(double tilt_rad, int64_t step);

  core::RobotModel robot_;
  WheelOdometryErrors errors_;
  uint64_t seed_;
  double left_radius_ = 1;
  double right_radius_ = 1;
  double true_track_m_ = 0;
  double forward_mps_ = 0;
  double yaw_rate_radps_ = 0;
  // The burst that goes on: until which step, which wheel, how much.
  int64_t burst_end_ = 0;
  bool burst_left_ = false;
  double burst_slip_ = 0;
  // What the counters say, before quantisation.
  double left_m_ = 0;
  double right_m_ = 0;
  // Of the step that waits for Commit.
  double pending_left_m_ = 0;
  double pending_right_m_ = 0;
  double pending_left_mps_ = 0;
  double pending_right_mps_ = 0;
};

// The inertial sensor of the same base.
class InertialSensor {
 public:
  InertialSensor(const WheelOdometryErrors& errors, uint64_t seed);

  // Completes a reading from the truth. `reading` numbers them, from 0 and
  // without gaps; `interval_s` lies between them.
  void Measure(double pitch_rad, double roll_rad, double yaw_rate_radps,
               int64_t number, double interval_s, core::BaseReading& reading);

 private:
  WheelOdometryErrors errors_;
  uint64_t seed_;
  double yaw_rate_factor_ = 1;
  double pitch_bias_rad_ = 0;
  double roll_bias_rad_ = 0;
  double last_pitch_rad_ = 0;
  double last_roll_rad_ = 0;
  bool has_last_ = false;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_DIFFERENTIAL_DRIVE_H_

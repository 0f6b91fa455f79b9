#include "simulation/simulator/differential_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "simulation/simulator/random_streams.h"

namespace treeline::simulator {
namespace {

constexpr double kGravity_mps2 = 9.81;
// Of what gravity pulls along a slope, what the motors cannot make up for.
constexpr double kGravityShare = 0.25;
constexpr double kMinAcceleration_mps2 = 0.1;
constexpr double kSlipperyTilt_rad = 0.035;
constexpr double kBiasTime_s = 300;

double Toward(double value, double target, double up, double down) {
  return value < target ? std::min(target, value + up)
                        : std::max(target, value - down);
}

double Quantized(double way_m, double counts_per_m) {
  return counts_per_m > 0 ? std::floor(way_m * counts_per_m) / counts_per_m
                          : way_m;
}

}  // namespace

WheelOdometryErrors WheelOdometryErrors::None() {
  return {.wheel_radius = 0,
          .track = 0,
          .distance_m_per_sqrt_m = 0,
          .turn_m_per_sqrt_rad = 0,
          .slope_slip = 0,
          .slip_bursts_hz = 0,
          .counts_per_m = 0,
          .tilt_noise_rad = 0,
          .tilt_bias_rad = 0,
          .yaw_rate_scale = 0,
          .yaw_rate_noise_radps = 0};
}

void WheelOdometryErrors::UseNoise(const core::MeasuredOdometryNoise& noise,
                                   double track_m) {
  // A wheel errs by d sqrt(way) of a way and t sqrt(turn) of a turn. Of both
  // wheels, the mean errs by 1 / sqrt(2) of that, the turn by sqrt(2) / track.
  // The measurement's stretches are so long.
  constexpr double kStretch_m = 0.5;
  constexpr double kStretch_rad = 0.35;
  distance_m_per_sqrt_m =
      std::sqrt(2 * kStretch_m) *
      std::max(noise.drive_from_drive, noise.turn_from_drive * track_m / 2);
  turn_m_per_sqrt_rad =
      std::sqrt(2 * kStretch_rad) *
      std::max(noise.drive_from_turn, noise.turn_from_turn * track_m / 2);
}

absl::Status WheelOdometryErrors::Validate() const {
  const std::pair<const char*, std::pair<double, double>> fields[] = {
      {"wheel_radius", {wheel_radius, 0.1}},
      {"track", {track, 0.1}},
      {"distance_m_per_sqrt_m", {distance_m_per_sqrt_m, 1}},
      {"turn_m_per_sqrt_rad", {turn_m_per_sqrt_rad, 1}},
      {"slope_slip", {slope_slip, 1}},
      {"slip_bursts_hz", {slip_bursts_hz, 100}},
      {"counts_per_m", {counts_per_m, 1e9}},
      {"tilt_noise_rad", {tilt_noise_rad, 1}},
      {"tilt_bias_rad", {tilt_bias_rad, 1}},
      {"yaw_rate_scale", {yaw_rate_scale, 0.5}},
      {"yaw_rate_noise_radps", {yaw_rate_noise_radps, 10}}};
  for (const auto& [name, value_and_max] : fields) {
    const auto [value, most] = value_and_max;
    if (!(value >= 0 && value <= most)) {
      return absl::InvalidArgumentError(
          absl::StrCat("drive errors: ", name, " is ", value,
                       "; it must be from 0 to ", most));
    }
  }
  return absl::OkStatus();
}

DifferentialDrive::DifferentialDrive(const core::RobotModel& robot,
                                     const WheelOdometryErrors& errors,
                                     uint64_t seed)
    : robot_(robot), errors_(errors), seed_(seed) {
  base::Random random = RandomFor(seed, SimRandom::kSystematic, 0);
  left_radius_ = 1 + errors.wheel_radius * random.NextGaussian();
  right_radius_ = 1 + errors.wheel_radius * random.NextGaussian();
  true_track_m_ =
      robot.wheel_track_m * (1 + errors.track * random.NextGaussian());
}

void DifferentialDrive::Accelerate(const core::VelocityCommand& target,
                                   double pitch_rad) {
  const double forward_target = std::clamp(
      target.forward_mps, -robot_.max_backward_mps, robot_.max_forward_mps);
  const double turn_target =
      std::clamp(target.yaw_rate_radps, -robot_.max_yaw_rate_radps,
                 robot_.max_yaw_rate_radps);
  // Towards standing still the robot brakes; away from it, it accelerates.
  const auto limit = [&](bool forwards) {
    const bool brakes = forwards ? forward_mps_ < 0 : forward_mps_ > 0;
    const double flat =
        brakes ? robot_.max_deceleration_mps2 : robot_.max_acceleration_mps2;
    const double pull = kGravityShare * kGravity_mps2 * std::sin(pitch_rad);
    return std::max(kMinAcceleration_mps2, flat + (forwards ? pull : -pull)) *
           kStep_s;
  };
  const bool crosses_zero = forward_target * forward_mps_ < 0;
  forward_mps_ = Toward(forward_mps_, crosses_zero ? 0 : forward_target,
                        limit(true), limit(false));
  const double turn_step = robot_.max_yaw_acceleration_radps2 * kStep_s;
  yaw_rate_radps_ = Toward(yaw_rate_radps_, turn_target, turn_step, turn_step);
}

void DifferentialDrive::BeginSlipBurst(double tilt_rad, int64_t step) {
  if (step < burst_end_ || tilt_rad < kSlipperyTilt_rad ||
      errors_.slip_bursts_hz <= 0 ||
      (forward_mps_ == 0 && yaw_rate_radps_ == 0)) {
    return;
  }
  base::Random random = RandomFor(seed_, SimRandom::kSlip, step);
  if (random.NextUnit() >= errors_.slip_bursts_hz * kStep_s) return;
  burst_end_ =
      step + static_cast<int64_t>(random.NextUniform(0.1, 0.4) / kStep_s);
  burst_left_ = random.NextUnit() < 0.5;
  burst_slip_ = random.NextUniform(0.2, 0.6);
}

PlanarMotion DifferentialDrive::Advance(const core::VelocityCommand& target,
                                        double pitch_rad, double tilt_rad,
                                        const WheelFaults& faults,
                                        int64_t step) {
  Accelerate(target, pitch_rad);
  BeginSlipBurst(tilt_rad, step);
  const double half_turn = 0.5 * yaw_rate_radps_ * robot_.wheel_track_m;
  pending_left_mps_ = faults.left_stuck ? 0 : forward_mps_ - half_turn;
  pending_right_mps_ = faults.right_stuck ? 0 : forward_mps_ + half_turn;

  const double climb = -std::sin(pitch_rad);
  const auto true_way = [&](double speed_mps, double radius, double fault_slip,
                            bool slips) {
    const double along_slope =
        errors_.slope_slip * climb * (speed_mps < 0 ? -1 : 1);
    const double burst = slips ? burst_slip_ : 0;
    return speed_mps * kStep_s * radius * (1 - along_slope) * (1 - burst) *
           (1 - fault_slip);
  };
  const bool in_burst = step < burst_end_;
  const double left_m = true_way(pending_left_mps_, left_radius_,
                                 faults.left_slip, in_burst && burst_left_);
  const double right_m = true_way(pending_right_mps_, right_radius_,
                                  faults.right_slip, in_burst && !burst_left_);

  // Counters err with the way, and with the turning.
  base::Random random = RandomFor(seed_, SimRandom::kWheels, step);
  const auto counted = [&](double speed_mps) {
    const double way_m = speed_mps * kStep_s;
    const double turn_rad = std::abs(yaw_rate_radps_) * kStep_s;
    const double variance =
        errors_.distance_m_per_sqrt_m * errors_.distance_m_per_sqrt_m *
            std::abs(way_m) +
        errors_.turn_m_per_sqrt_rad * errors_.turn_m_per_sqrt_rad * turn_rad;
    const double noise = random.NextGaussian();
    return way_m == 0 ? 0 : way_m + std::sqrt(variance) * noise;
  };
  pending_left_m_ = counted(pending_left_mps_);
  pending_right_m_ = counted(pending_right_mps_);
  return {.forward_m = 0.5 * (left_m + right_m),
          .turn_rad = (right_m - left_m) / true_track_m_};
}

void DifferentialDrive::Commit() {
  left_m_ += pending_left_m_;
  right_m_ += pending_right_m_;
}

void DifferentialDrive::Block() {
  forward_mps_ = 0;
  yaw_rate_radps_ = 0;
  pending_left_mps_ = 0;
  pending_right_mps_ = 0;
}

core::BaseReading DifferentialDrive::Counters() const {
  core::BaseReading reading;
  reading.left_wheel_m = Quantized(left_m_, errors_.counts_per_m);
  reading.right_wheel_m = Quantized(right_m_, errors_.counts_per_m);
  reading.forward_mps = 0.5 * (pending_left_mps_ + pending_right_mps_);
  return reading;
}

void DifferentialDrive::ResetCounters() {
  left_m_ = 0;
  right_m_ = 0;
}

InertialSensor::InertialSensor(const WheelOdometryErrors& errors, uint64_t seed)
    : errors_(errors), seed_(seed) {
  base::Random random = RandomFor(seed, SimRandom::kSystematic, 1);
  yaw_rate_factor_ = 1 + errors.yaw_rate_scale * random.NextGaussian();
  pitch_bias_rad_ = errors.tilt_bias_rad * random.NextGaussian();
  roll_bias_rad_ = errors.tilt_bias_rad * random.NextGaussian();
}

void InertialSensor::Measure(double pitch_rad, double roll_rad,
                             double yaw_rate_radps, int64_t number,
                             double interval_s, core::BaseReading& reading) {
  // Ornstein-Uhlenbeck: the bias keeps its standard deviation.
  base::Random wander = RandomFor(seed_, SimRandom::kInertialBias, number);
  const double keep = std::exp(-interval_s / kBiasTime_s);
  const double kick = std::sqrt(1 - keep * keep) * errors_.tilt_bias_rad;
  pitch_bias_rad_ = keep * pitch_bias_rad_ + kick * wander.NextGaussian();
  roll_bias_rad_ = keep * roll_bias_rad_ + kick * wander.NextGaussian();

  base::Random random = RandomFor(seed_, SimRandom::kInertial, number);
  reading.pitch_rad = pitch_rad + pitch_bias_rad_ +
                      errors_.tilt_noise_rad * random.NextGaussian();
  reading.roll_rad = roll_rad + roll_bias_rad_ +
                     errors_.tilt_noise_rad * random.NextGaussian();
  reading.yaw_rate_radps = yaw_rate_radps * yaw_rate_factor_ +
                           errors_.yaw_rate_noise_radps * random.NextGaussian();
  reading.pitch_rate_radps =
      has_last_ ? (pitch_rad - last_pitch_rad_) / interval_s : 0;
  reading.roll_rate_radps =
      has_last_ ? (roll_rad - last_roll_rad_) / interval_s : 0;
  last_pitch_rad_ = pitch_rad;
  last_roll_rad_ = roll_rad;
  has_last_ = true;
}

}  // namespace treeline::simulator

// Wheels that err as their model says.
#include <cmath>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"
#include "simulation/simulator/differential_drive.h"
#include "simulation/simulator/testing_simulator.h"

namespace treeline::simulator {
namespace {

constexpr int kRuns = 400;

struct Spread {
  double mean = 0;
  double deviation = 0;
};

Spread SpreadOf(const std::vector<double>& values) {
  Spread spread;
  for (const double value : values) spread.mean += value;
  spread.mean /= static_cast<double>(values.size());
  for (const double value : values) {
    spread.deviation += (value - spread.mean) * (value - spread.mean);
  }
  spread.deviation =
      std::sqrt(spread.deviation / static_cast<double>(values.size() - 1));
  return spread;
}

struct Result {
  double true_m = 0;
  double true_rad = 0;
  core::BaseReading counters;
};

Result DriveFor(const WheelOdometryErrors& errors, uint64_t seed,
                const core::VelocityCommand& command, double duration_s,
                double pitch_rad = 0) {
  DifferentialDrive drive(core::RobotModel(), errors, seed);
  Result run;
  const auto steps =
      static_cast<int64_t>(duration_s / DifferentialDrive::kStep_s);
  for (int64_t step = 0; step < steps; ++step) {
    const PlanarMotion motion = drive.Advance(
        command, pitch_rad, std::abs(pitch_rad), WheelFaults{}, step);
    drive.Commit();
    run.true_m += motion.forward_m;
    run.true_rad += motion.turn_rad;
  }
  run.counters = drive.Counters();
  return run;
}

TEST(WheelOdometryErrors, NoneMeansNone) {
  const Result run =
      DriveFor(WheelOdometryErrors::None(), 3, {0.5, 0.3}, 10, -0.1);
  EXPECT_NEAR(0.5 * (run.counters.left_wheel_m + run.counters.right_wheel_m),
              run.true_m, 1e-9);
  EXPECT_NEAR((run.counters.right_wheel_m - run.counters.left_wheel_m) /
                  core::RobotModel().wheel_track_m,
              run.true_rad, 1e-9);
}

// Over half a metre, the way's error; over 20 degrees, the turn's.
TEST(WheelOdometryErrors, WheelsErrAsARobotWasMeasuredTo) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  const double track_m = core::RobotModel().wheel_track_m;
  errors.UseNoise({.turn_from_turn = 0.05,
                   .turn_from_drive = 0.01,
                   .drive_from_drive = 0.04,
                   .drive_from_turn = 0.001},
                  track_m);
  ASSERT_TRUE(errors.Validate().ok());
  std::vector<double> along;
  std::vector<double> yaw;
  double way_m = 0;
  double turn_rad = 0;
  for (uint64_t seed = 0; seed < kRuns; ++seed) {
    const Result ahead = DriveFor(errors, seed, {0.5, 0}, 1.3);
    along.push_back(
        0.5 * (ahead.counters.left_wheel_m + ahead.counters.right_wheel_m) -
        ahead.true_m);
    way_m = ahead.true_m;
    const Result turns = DriveFor(errors, seed, {0, 0.5}, 0.8);
    yaw.push_back((turns.counters.right_wheel_m - turns.counters.left_wheel_m) /
                      track_m -
                  turns.true_rad);
    turn_rad = turns.true_rad;
  }
  EXPECT_NEAR(way_m, 0.5, 0.06);
  EXPECT_NEAR(turn_rad, 0.35, 0.04);
  // 400 runs tell a deviation to 4 / sqrt(800); the way is so far from its
  // stretch; and turns on the spot are ways of both wheels, too.
  EXPECT_NEAR(SpreadOf(along).deviation, 0.04 * way_m, 0.25 * 0.04 * way_m);
  EXPECT_GT(SpreadOf(yaw).deviation, 0.75 * 0.05 * turn_rad);
  EXPECT_LT(SpreadOf(yaw).deviation, 4 * 0.05 * turn_rad);
}

TEST(WheelOdometryErrors, CountersSpreadWithTheSquareRootOfTheWay) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  errors.distance_m_per_sqrt_m = 0.02;
  for (const double duration_s : {5.0, 20.0}) {
    std::vector<double> left_off;
    double way_m = 0;
    for (uint64_t seed = 0; seed < kRuns; ++seed) {
      const Result run = DriveFor(errors, seed, {0.5, 0}, duration_s);
      left_off.push_back(run.counters.left_wheel_m - run.true_m);
      way_m = run.true_m;
    }
    const Spread spread = SpreadOf(left_off);
    const double expected_m = 0.02 * std::sqrt(way_m);
    // Of 400 runs, the mean is within 4 of its own deviations, and the
    // deviation within 4 / sqrt(800) of its value.
    EXPECT_LT(std::abs(spread.mean), 4 * expected_m / std::sqrt(kRuns));
    EXPECT_NEAR(spread.deviation, expected_m, 0.142 * expected_m);
  }
}

TEST(WheelOdometryErrors, TurningSpreadsThemToo) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  errors.turn_m_per_sqrt_rad = 0.01;
  std::vector<double> off_rad;
  double turned_rad = 0;
  for (uint64_t seed = 0; seed < kRuns; ++seed) {
    const Result run = DriveFor(errors, seed, {0, 1}, 10);
    turned_rad = run.true_rad;
    off_rad.push_back((run.counters.right_wheel_m - run.counters.left_wheel_m) /
                          core::RobotModel().wheel_track_m -
                      run.true_rad);
  }
  // Two wheels with independent noise.
  const double expected_rad =
      std::sqrt(2 * turned_rad) * 0.01 / core::RobotModel().wheel_track_m;
  EXPECT_NEAR(SpreadOf(off_rad).deviation, expected_rad, 0.142 * expected_rad);
}

TEST(WheelOdometryErrors, RadiiAndTrackAreDrawnOnceForASeed) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  errors.wheel_radius = 0.01;
  errors.track = 0.02;
  std::vector<double> scale;
  std::vector<double> turn_scale;
  for (uint64_t seed = 0; seed < kRuns; ++seed) {
    const Result straight = DriveFor(errors, seed, {0.5, 0}, 4);
    scale.push_back(straight.true_m / straight.counters.left_wheel_m);
    const Result turn = DriveFor(errors, seed, {0, 1}, 4);
    turn_scale.push_back(
        turn.true_rad * core::RobotModel().wheel_track_m /
        (turn.counters.right_wheel_m - turn.counters.left_wheel_m));
  }
  // The mean of two wheels; turning has that and the track.
  const double expected = 0.01 / std::sqrt(2);
  EXPECT_NEAR(SpreadOf(scale).deviation, expected, 0.142 * expected);
  EXPECT_NEAR(SpreadOf(scale).mean, 1, 4 * expected / std::sqrt(kRuns));
  const double expected_turn = std::hypot(expected, 0.02);
  EXPECT_NEAR(SpreadOf(turn_scale).deviation, expected_turn,
              0.15 * expected_turn);
}

TEST(WheelOdometryErrors, SlopesSlip) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  errors.slope_slip = 0.1;
  const double slope_rad = 0.1;
  const double share = 0.1 * std::sin(slope_rad);
  const Result up = DriveFor(errors, 0, {0.5, 0}, 10, -slope_rad);
  EXPECT_NEAR(up.true_m / up.counters.left_wheel_m, 1 - share, 1e-9);
  const Result down = DriveFor(errors, 0, {0.5, 0}, 10, slope_rad);
  EXPECT_NEAR(down.true_m / down.counters.left_wheel_m, 1 + share, 1e-9);
  const Result back_up = DriveFor(errors, 0, {-0.3, 0}, 10, slope_rad);
  EXPECT_NEAR(back_up.true_m / back_up.counters.left_wheel_m, 1 - share, 1e-9);
}

TEST(WheelOdometryErrors, BurstsOfSlipComeOnSlopesOnlyAndAsOftenAsTheyShould) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  errors.slip_bursts_hz = 0.5;
  const Result level = DriveFor(errors, 0, {0.5, 0}, 100);
  EXPECT_NEAR(level.true_m, level.counters.left_wheel_m, 1e-9);
  std::vector<double> lost;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    const Result slope = DriveFor(errors, seed, {0.5, 0}, 100, -0.1);
    lost.push_back(1 - slope.true_m / slope.counters.left_wheel_m);
  }
  // A burst lasts 0.25 s on average and takes 0.4 of one of two wheels; none
  // begins in another: 0.5 bursts in 1 + 0.5 * 0.25 seconds.
  const double expected = 0.5 / 1.125 * 0.25 * 0.4 / 2;
  const Spread spread = SpreadOf(lost);
  EXPECT_NEAR(spread.mean, expected, 4 * spread.deviation / std::sqrt(40.0));
  EXPECT_GT(spread.deviation, 0.0005);
}

TEST(WheelOdometryErrors, CountersStepAsTheEncodersDo) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  errors.counts_per_m = 100;
  const Result run = DriveFor(errors, 0, {0.5, 0}, 3);
  const double counts = run.counters.left_wheel_m * 100;
  EXPECT_NEAR(counts, std::round(counts), 1e-9);
  EXPECT_GE(run.true_m, run.counters.left_wheel_m);
  EXPECT_LT(run.true_m, run.counters.left_wheel_m + 0.01);
}

TEST(WheelOdometryErrors, TiltsAreNoisyAndBiased) {
  WheelOdometryErrors errors = WheelOdometryErrors::None();
  errors.tilt_noise_rad = 0.003;
  errors.tilt_bias_rad = 0.01;
  std::vector<double> biases;
  std::vector<double> noises;
  for (uint64_t seed = 0; seed < kRuns; ++seed) {
    InertialSensor sensor(errors, seed);
    std::vector<double> pitches;
    for (int64_t i = 0; i < 50; ++i) {
      core::BaseReading reading;
      sensor.Measure(0.1, 0, 0, i, 0.01, reading);
      pitches.push_back(reading.pitch_rad - 0.1);
    }
    biases.push_back(SpreadOf(pitches).mean);
    noises.push_back(SpreadOf(pitches).deviation);
  }
  EXPECT_NEAR(SpreadOf(biases).deviation, 0.01, 0.0015);
  EXPECT_NEAR(SpreadOf(noises).mean, 0.003, 0.0003);
}

TEST(WheelOdometryErrors, AreRefusedOutOfRange) {
  EXPECT_TRUE(WheelOdometryErrors().Validate().ok());
  WheelOdometryErrors errors;
  errors.track = -0.1;
  EXPECT_FALSE(errors.Validate().ok());
  errors.track = std::nan("");
  EXPECT_FALSE(errors.Validate().ok());
}

}  // namespace
}  // namespace treeline::simulator

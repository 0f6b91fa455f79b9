#include "nav_agent/localization/odometry_motion.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::localization {
namespace {

constexpr int kDraws = 20000;
// Of a mean and a standard deviation of so many draws: five of its own.
constexpr double kMeanError = 5 / 141.0;
constexpr double kSigmaError = 5 / 200.0;

struct Spread {
  double mean = 0;
  double sigma = 0;
};

Spread SpreadOf(const std::vector<double>& values) {
  Spread spread;
  const double count = static_cast<double>(values.size());
  for (const double value : values) spread.mean += value / count;
  for (const double value : values) {
    const double away = value - spread.mean;
    spread.sigma += away * away / count;
  }
  spread.sigma = std::sqrt(spread.sigma);
  return spread;
}

TEST(OdometryMotion, WithoutNoiseIsTheMotionItself) {
  const OdometryNoise none = {0, 0, 0, 0};
  const geometry::Rigid2 map_from_before = {.translation = {1, 2},
                                            .yaw_rad = 2};
  const geometry::Rigid2 moves[] = {
      {{0.4, 0.1}, 0.5}, {{-0.3, 0.02}, 0.1}, {{0, 0}, -1}};
  for (const geometry::Rigid2& move : moves) {
    base::Random random(1, 1);
    const geometry::Rigid2 moved =
        OdometryMotion(move, none).Sample(map_from_before, random);
    const geometry::Rigid2 expected = map_from_before * move;
    EXPECT_NEAR(moved.translation.x, expected.translation.x, 1e-12);
    EXPECT_NEAR(moved.translation.y, expected.translation.y, 1e-12);
    EXPECT_NEAR(geometry::NormalizedAngle_rad(moved.yaw_rad - expected.yaw_rad),
                0, 1e-12);
  }
}

TEST(OdometryMotion, NoiseIsAsStated) {
  const OdometryNoise noise = {.turn_from_turn = 0.2,
                               .turn_from_drive = 0.1,
                               .drive_from_drive = 0.05,
                               .drive_from_turn = 0.03};
  // 1 m ahead, then a turn of 0.5: turns have sigma 0.1 and 0.1 + 0.1, the way
  // 0.05 + 0.015.
  const OdometryMotion motion({{1, 0}, 0.5}, noise);
  std::vector<double> ways;
  std::vector<double> courses;
  std::vector<double> turns;
  for (uint64_t i = 0; i < kDraws; ++i) {
    base::Random random(5, i);
    const geometry::Rigid2 moved = motion.Sample({}, random);
    // Along the course that was driven, which may be backwards by no chance.
    ways.push_back(geometry::Norm(moved.translation));
    courses.push_back(std::atan2(moved.translation.y, moved.translation.x));
    turns.push_back(moved.yaw_rad - courses.back());
  }
  EXPECT_NEAR(SpreadOf(ways).mean, 1, 0.065 * kMeanError);
  EXPECT_NEAR(SpreadOf(ways).sigma, 0.065, 0.065 * kSigmaError);
  EXPECT_NEAR(SpreadOf(courses).mean, 0, 0.1 * kMeanError);
  EXPECT_NEAR(SpreadOf(courses).sigma, 0.1, 0.1 * kSigmaError);
  EXPECT_NEAR(SpreadOf(turns).mean, 0.5, 0.2 * kMeanError);
  EXPECT_NEAR(SpreadOf(turns).sigma, 0.2, 0.2 * kSigmaError);
}

TEST(OdometryMotion, DrivingBackwardsIsNoHalfTurn) {
  const OdometryNoise noise = {.turn_from_turn = 0.2,
                               .turn_from_drive = 0,
                               .drive_from_drive = 0,
                               .drive_from_turn = 0.1};
  base::Random random(1, 1);
  const geometry::Rigid2 moved =
      OdometryMotion({{-1, 0}, 0}, noise).Sample({}, random);
  EXPECT_NEAR(moved.translation.x, -1, 1e-9);
  EXPECT_NEAR(moved.yaw_rad, 0, 1e-9);
}

// Slow steps back are millimetres from one scan to the next.
TEST(OdometryMotion, ShortStepsLeadBackAsTheyLeadAhead) {
  const OdometryNoise none = {0, 0, 0, 0};
  for (const double step_m : {-0.02, -0.006, -0.0015, 0.0015, 0.006, 0.02}) {
    geometry::Rigid2 at;
    base::Random random(1, 1);
    for (int step = 0; step < 10; ++step) {
      at = OdometryMotion({{step_m, 1e-5}, 0.001}, none).Sample(at, random);
    }
    EXPECT_NEAR(at.translation.x, 10 * step_m, 0.01 * std::abs(step_m));
    EXPECT_NEAR(at.yaw_rad, 0.01, 1e-9);
  }
}

TEST(OdometryNoise, RefusesWhatIsNoShare) {
  EXPECT_TRUE(OdometryNoise().Validate().ok());
  EXPECT_EQ(OdometryNoise{.drive_from_turn = -1}.Validate().message(),
            "odometry noise: drive_from_turn is -1; it must be 0..10");
}

TEST(OdometryNoise, OfAMeasuredRobotHasAMarginAndIsNoLessThanUsual) {
  const OdometryNoise noise = OdometryNoise::Of({.turn_from_turn = 0.15,
                                                 .turn_from_drive = 0.001,
                                                 .drive_from_drive = 0.2,
                                                 .drive_from_turn = 0.001});
  EXPECT_DOUBLE_EQ(noise.turn_from_turn, kNoiseMargin * 0.15);
  EXPECT_DOUBLE_EQ(noise.turn_from_drive, kTurnFromDrive);
  EXPECT_DOUBLE_EQ(noise.drive_from_drive, kNoiseMargin * 0.2);
  EXPECT_DOUBLE_EQ(noise.drive_from_turn, kDriveFromTurn);
  // The most that files may say is still valid.
  EXPECT_TRUE(OdometryNoise::Of({core::kMostNoise, core::kMostNoise,
                                 core::kMostNoise, core::kMostNoise})
                  .Validate()
                  .ok());
}

}  // namespace
}  // namespace treeline::localization

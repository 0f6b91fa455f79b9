#include "nav_agent/calibration/calibration.h"

#include <cmath>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/calibration/calibration_text.h"
#include "nav_agent/calibration/testing_drive.h"

namespace treeline::calibration {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A right wheel that is 1 % larger, a track 3 % wider, a laser turned by 1.5
// degrees and moved by 4 cm, whose scans are 40 ms late.
TestDriveOptions Planted(uint64_t seed) {
  TestDriveOptions options;
  options.seed = seed;
  options.assumed = {.wheels = {.track_m = 0.54},
                     .base_from_laser = {{0.22, 0}, 0}};
  options.truth = {.wheels = {.left_scale = 1.0,
                              .right_scale = 1.01,
                              .track_m = 0.54 * 1.03},
                   .base_from_laser = {{0.26, -0.04}, 0.0262},
                   .laser_delay_s = 0.04};
  return options;
}

Calibration CalibrateTest(const TestDriveOptions& options) {
  const auto drive = BuildDrive(TestDriveEntries(options));
  EXPECT_TRUE(drive.ok()) << drive.status();
  auto calibration = Calibrate(*drive, AssumedSetup(drive->robot));
  EXPECT_TRUE(calibration.ok()) << calibration.status();
  return *std::move(calibration);
}

void ExpectFound(const Calibration& calibration, const Setup& truth,
                 const std::string& what) {
  for (int i = 0; i < kQuantities; ++i) {
    const auto quantity = static_cast<Quantity>(i);
    const Estimate& estimate = calibration.Of(quantity);
    EXPECT_TRUE(estimate.is_known) << what << NameOf(quantity);
    EXPECT_NEAR(estimate.value, ValueOf(truth, quantity), 3 * estimate.sigma)
        << what << NameOf(quantity);
  }
}

// Over 40 more seeds: docs/research/calibration.md.
TEST(Calibration, FindsPlantedErrorsWithinWhatItStates) {
  for (const uint64_t seed : {1u, 2u}) {
    const TestDriveOptions options = Planted(seed);
    const Calibration calibration = CalibrateTest(options);
    ExpectFound(calibration, options.truth, absl::StrCat("seed ", seed, ": "));
    // It is not sure of nothing: a wheel to half a per cent, a laser to a
    // quarter of a degree and a centimetre, 5 ms.
    EXPECT_LT(calibration.Of(Quantity::kRightScale).sigma, 0.005);
    EXPECT_LT(calibration.Of(Quantity::kTrack).sigma, 0.006);
    EXPECT_LT(calibration.Of(Quantity::kLaserX).sigma, 0.01);
    EXPECT_LT(calibration.Of(Quantity::kLaserYaw).sigma, 0.0044);
    EXPECT_LT(calibration.Of(Quantity::kLaserDelay).sigma, 0.005);
    EXPECT_LT(calibration.after.rms_m, 0.5 * calibration.before.rms_m);
    EXPECT_LT(calibration.held_out.rms_m, 0.5 * calibration.before.rms_m);
    EXPECT_LT(calibration.held_out.rms_rad, 0.7 * calibration.before.rms_rad);
    // What was planted is seen.
    EXPECT_EQ(FindMisfits(calibration).size(), 6);  // all but the left wheel
  }
}

TEST(Calibration, FindsNothingWhereNothingIsWrong) {
  TestDriveOptions options = Planted(4);
  options.truth = options.assumed;
  const Calibration calibration = CalibrateTest(options);
  ExpectFound(calibration, options.truth, "");
  EXPECT_THAT(FindMisfits(calibration), IsEmpty());
}

TEST(Calibration, FindsALaserThatLooksAnywhere) {
  TestDriveOptions options = Planted(5);
  options.truth.base_from_laser = {{0.1, 0.05}, 1.2};
  const Calibration calibration = CalibrateTest(options);
  const Estimate& yaw = calibration.Of(Quantity::kLaserYaw);
  EXPECT_TRUE(yaw.is_known);
  EXPECT_NEAR(yaw.value, 1.2, 3 * yaw.sigma);
}

TEST(Calibration, TellsTheGyroscopeApart) {
  TestDriveOptions options = Planted(6);
  options.yaw_rate_scale = 1.02;
  options.yaw_rate_bias_radps = 0.003;
  const Calibration calibration = CalibrateTest(options);
  ASSERT_TRUE(calibration.gyroscope.has_value());
  const Gyroscope& gyroscope = *calibration.gyroscope;
  EXPECT_TRUE(gyroscope.scale.is_known);
  EXPECT_NEAR(gyroscope.scale.value, 1.02, 3 * gyroscope.scale.sigma + 0.002);
  EXPECT_NEAR(gyroscope.bias_radps.value, 0.003,
              3 * gyroscope.bias_radps.sigma + 0.0005);
}

// A corridor's length and back would do; the robot stops before it turns.
TEST(Calibration, SaysWhatAStraightDriveDoesNotShow) {
  TestDriveOptions options = Planted(7);
  options.way = {{-5.0, -2.5}, {500, -2.5}};
  options.seconds = 17;
  const Calibration calibration = CalibrateTest(options);
  EXPECT_FALSE(calibration.Of(Quantity::kTrack).is_known);
  EXPECT_FALSE(calibration.Of(Quantity::kLaserX).is_known);
  EXPECT_FALSE(calibration.Of(Quantity::kLaserY).is_known);
  // What is not known stays as it was.
  EXPECT_EQ(calibration.found.wheels.track_m, 0.54);
  EXPECT_EQ(calibration.found.base_from_laser.translation.x, 0.22);
  const Estimate& yaw = calibration.Of(Quantity::kLaserYaw);
  EXPECT_TRUE(yaw.is_known);
  EXPECT_NEAR(yaw.value, options.truth.base_from_laser.yaw_rad, 3 * yaw.sigma);
  const std::string table = CalibrationTable(calibration);
  EXPECT_THAT(table, HasSubstr("not observable in this drive"));
  EXPECT_THAT(table, HasSubstr("turn on the spot, a few whole turns each way"));
  EXPECT_THAT(EntriesYaml(RobotFileEntries(calibration, 0.3), ""),
              Not(HasSubstr("wheel_track_m")));
  // Where the laser looks was found; where it is stays as it was.
  const std::string ros =
      EntriesYaml(RosFileEntries(calibration, 0.54, 0.3), "");
  EXPECT_THAT(ros, Not(HasSubstr("turn_scale")));
  EXPECT_THAT(ros, HasSubstr("base_from_laser: [0.2200, 0.0000, 0.3000, "));
}

TEST(Calibration, SaysThatARobotStood) {
  TestDriveOptions options = Planted(8);
  options.seconds = 3;
  auto entries = TestDriveEntries(options);
  for (auto& entry : entries) {
    if (auto* reading = std::get_if<core::BaseReading>(&entry)) {
      reading->left_wheel_m = reading->right_wheel_m = 1;
    }
  }
  const auto drive = BuildDrive(entries);
  EXPECT_EQ(drive.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(drive.status().message(), HasSubstr("wheels did not turn"));
}

TEST(Calibration, SaysThatADriveIsTooShort) {
  TestDriveOptions options = Planted(9);
  options.seconds = 6;
  const auto drive = BuildDrive(TestDriveEntries(options));
  ASSERT_TRUE(drive.ok());
  const auto calibration = Calibrate(*drive, AssumedSetup(drive->robot));
  EXPECT_THAT(calibration.status().message(),
              HasSubstr("drive for some minutes"));
}

TEST(Calibration, SaysThatScansAndWheelsAreMissing) {
  TestDriveOptions options = Planted(10);
  options.seconds = 3;
  const auto entries = TestDriveEntries(options);
  DriveBuilder no_scans;
  DriveBuilder no_wheels;
  DriveBuilder other_beams;
  for (const auto& entry : entries) {
    if (!std::holds_alternative<core::LaserScan>(entry)) no_scans.Take(entry);
    if (!std::holds_alternative<core::BaseReading>(entry)) {
      no_wheels.Take(entry);
    }
    if (const auto* info = std::get_if<core::RangeSensorInfo>(&entry)) {
      core::RangeSensorInfo other = *info;
      other.beams += 1;
      other_beams.Take(other);
    } else {
      other_beams.Take(entry);
    }
  }
  EXPECT_THAT(no_scans.Build().status().message(), HasSubstr("no laser scans"));
  EXPECT_THAT(no_wheels.Build().status().message(), HasSubstr("no odometry"));
  EXPECT_THAT(other_beams.Build().status().message(),
              HasSubstr("number of beams"));
}

// The clock jumps back by 1000 s in the middle, some readings are NaN, a
// counter begins anew, some scans are NaN: the rest is enough, and right.
TEST(Calibration, GoesOnAfterWhatIsBroken) {
  const TestDriveOptions options = Planted(11);
  auto entries = TestDriveEntries(options);
  int i = 0;
  double lost_m = 0;
  for (auto& entry : entries) {
    ++i;
    const bool is_late = i > 3000;
    if (auto* reading = std::get_if<core::BaseReading>(&entry)) {
      if (i % 100 == 0) {
        reading->left_wheel_m = std::numeric_limits<double>::quiet_NaN();
      }
      if (i > 4000) {
        if (lost_m == 0) lost_m = reading->right_wheel_m;
        reading->right_wheel_m -= lost_m;
      }
      if (is_late) reading->stamp -= std::chrono::seconds(1000);
    } else if (auto* scan = std::get_if<core::LaserScan>(&entry)) {
      if (i % 50 == 0) {
        scan->ranges_m.assign(scan->ranges_m.size(),
                              std::numeric_limits<float>::quiet_NaN());
      }
      if (is_late) scan->stamp -= std::chrono::seconds(1000);
    }
  }
  const auto drive = BuildDrive(entries);
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_THAT(absl::StrCat(drive->notes[0], drive->notes[1]),
              HasSubstr("jumped back"));
  const auto calibration = Calibrate(*drive, AssumedSetup(drive->robot));
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  ExpectFound(*calibration, options.truth, "");
}

// Wheels that slip are outliers: a tenth of the drive on ice.
TEST(Calibration, IsNotMovedByWheelsThatSlip) {
  const TestDriveOptions options = Planted(12);
  auto entries = TestDriveEntries(options);
  double slipped_m = 0;
  double last_m = 0;
  int i = 0;
  for (auto& entry : entries) {
    auto* reading = std::get_if<core::BaseReading>(&entry);
    if (reading == nullptr) continue;
    const double rolled_m = reading->left_wheel_m - last_m;
    last_m = reading->left_wheel_m;
    if (++i % 1000 < 100) slipped_m += 0.6 * rolled_m;
    reading->left_wheel_m += slipped_m;
  }
  const auto drive = BuildDrive(entries);
  ASSERT_TRUE(drive.ok());
  const auto calibration = Calibrate(*drive, AssumedSetup(drive->robot));
  ASSERT_TRUE(calibration.ok());
  EXPECT_GE(calibration->outliers, 3);
  ExpectFound(*calibration, options.truth, "");
}

TEST(Calibration, StopsWhenItIsAsked) {
  TestDriveOptions options = Planted(13);
  options.seconds = 20;
  const auto drive = BuildDrive(TestDriveEntries(options));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(Calibrate(*drive, AssumedSetup(drive->robot), stop.get_token())
                .status()
                .code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace treeline::calibration

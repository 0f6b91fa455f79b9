#include "nav_agent/app/calibrate/calibrate_run.h"

#include <memory>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/calibration/testing_drive.h"

namespace treeline::calibrate_app {
namespace {

using calibration::Quantity;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

// A drive of a robot that is not as its log says, as a file.
class CalibrateRun : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.truth = {
        .wheels = {.left_scale = 0.99, .right_scale = 1.01, .track_m = 0.56},
        .base_from_laser = {{0.26, -0.04}, 0.03},
        .laser_delay_s = 0.03};
    options_.assumed = {.wheels = {.track_m = 0.54},
                        .base_from_laser = {{0.22, 0}, 0}};
    options_.seconds = 50;
    log_ = folder_.Path("drive.tlog");
    const base::SteadyClock clock;
    const auto writer = recording::AgentLogWriter::Open(log_, false, clock);
    ASSERT_TRUE(writer.ok());
    for (const auto& entry : calibration::TestDriveEntries(options_)) {
      ASSERT_TRUE((*writer)->Write(entry).ok());
    }
  }

  base::TestingFolder folder_;
  calibration::TestDriveOptions options_;
  std::string log_;
};

TEST_F(CalibrateRun, WritesFilesThatThenFit) {
  const std::string robot = folder_.Path("robot.yaml");
  ASSERT_TRUE(base::WriteFileAtomically(robot, "like: rmp100  # ours\n").ok());
  const auto found = RunCalibration({.log = log_,
                                     .write = robot,
                                     .yaml = folder_.Path("found.yaml"),
                                     .json = folder_.Path("found.json"),
                                     .picture = folder_.Path("found.png")},
                                    {});
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_THAT(calibration::FindMisfits(found->calibration), Not(IsEmpty()));
  EXPECT_THAT(*base::ReadFile(robot), StartsWith("like: rmp100  # ours\n"));
  EXPECT_THAT(*base::ReadFile(folder_.Path("found.yaml")),
              HasSubstr("wheel_track_m: 0.5"));
  EXPECT_THAT(*base::ReadFile(folder_.Path("found.json")),
              HasSubstr("\"held_out\""));
  EXPECT_THAT(*base::ReadFile(folder_.Path("found.png")),
              StartsWith("\x89PNG"));
  const auto setup = ReadSetup(robot);
  ASSERT_TRUE(setup.ok()) << setup.status();
  for (int i = 0; i < calibration::kQuantities; ++i) {
    const auto q = static_cast<Quantity>(i);
    // Files have four digits.
    EXPECT_NEAR(calibration::ValueOf(*setup, q), found->calibration.Of(q).value,
                6e-5);
  }
  // The same drive against the file: it fits now.
  const auto again = RunCalibration({.log = log_, .robot = robot}, {});
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_THAT(calibration::FindMisfits(again->calibration), IsEmpty());
  // So does the noise, which is that of this very drive.
  ASSERT_TRUE(setup->noise.has_value());
  ASSERT_TRUE(found->calibration.noise.has_value());
  EXPECT_NEAR(setup->noise->turn_from_turn,
              found->calibration.noise->noise.turn_from_turn, 6e-5);
  EXPECT_GT(again->calibration.excess.along, 0.5);
  EXPECT_EQ(calibration::NoiseMisfit(again->calibration), "");
}

TEST_F(CalibrateRun, SaysThatOdometryErrsMoreThanTheFileSays) {
  const std::string robot = folder_.Path("robot.yaml");
  ASSERT_TRUE(base::WriteFileAtomically(
                  robot,
                  "odometry: {turn_from_turn: 0.001, turn_from_drive: 0.001, "
                  "drive_from_drive: 0.001, drive_from_turn: 0.001}\n")
                  .ok());
  const auto found = RunCalibration({.log = log_, .robot = robot}, {});
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_THAT(calibration::NoiseMisfit(found->calibration),
              HasSubstr("as much as the odometry noise says"));
}

TEST_F(CalibrateRun, ACorrectedLogNeedsNoCalibration) {
  const std::string corrected = folder_.Path("corrected.tlog");
  const auto found = RunCalibration({.log = log_, .corrected = corrected}, {});
  ASSERT_TRUE(found.ok()) << found.status();
  const auto again = RunCalibration({.log = corrected}, {});
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_THAT(calibration::FindMisfits(again->calibration), IsEmpty());
  EXPECT_NEAR(again->calibration.before.rms_m, found->calibration.after.rms_m,
              0.001);
  EXPECT_EQ(
      RunCalibration({.log = log_, .corrected = corrected}, {}).status().code(),
      absl::StatusCode::kAlreadyExists);
}

TEST_F(CalibrateRun, WritesHardwareFiles) {
  const std::string hardware = folder_.Path("hardware.yaml");
  ASSERT_TRUE(base::WriteFileAtomically(hardware,
                                        "laser: tcp:10.0.0.1  # UTM-30LX-EW\n"
                                        "base: /dev/ttyUSB0@460800\n"
                                        "laser_x_m: 0.22\n")
                  .ok());
  const auto found =
      RunCalibration({.log = log_, .robot = hardware, .write = hardware}, {});
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_THAT(*base::ReadFile(hardware),
              StartsWith("laser: tcp:10.0.0.1  # UTM-30LX-EW\n"));
  const auto setup = ReadSetup(hardware);
  ASSERT_TRUE(setup.ok()) << setup.status();
  EXPECT_NEAR(setup->wheels.left_scale,
              found->calibration.Of(Quantity::kLeftScale).value, 6e-5);
  EXPECT_NEAR(setup->base_from_laser.yaw_rad,
              found->calibration.Of(Quantity::kLaserYaw).value, 6e-5);
  EXPECT_NEAR(setup->laser_delay_s,
              found->calibration.Of(Quantity::kLaserDelay).value, 6e-5);
  ASSERT_TRUE(setup->noise.has_value());
  EXPECT_NEAR(setup->noise->drive_from_drive,
              found->calibration.noise->noise.drive_from_drive, 6e-5);
}

// Turns of its odometry do not follow from the track: what is found of that is
// a scale, and the file then says the same as the log and the drive.
TEST_F(CalibrateRun, WritesFilesOfRos) {
  const std::string ros = folder_.Path("ros.yaml");
  ASSERT_TRUE(base::WriteFileAtomically(ros,
                                        "domain_id: 7\n"
                                        "wheel_track_m: 0.5  # by tape\n")
                  .ok());
  const auto found = RunCalibration({.log = log_, .write = ros}, {});
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_THAT(*base::ReadFile(ros),
              StartsWith("domain_id: 7\nwheel_track_m: 0.5  # by tape\n"));
  // /tf_static says where its laser is.
  EXPECT_THAT(*base::ReadFile(ros), Not(HasSubstr("base_from_laser")));
  EXPECT_THAT(found->notes, Contains(HasSubstr("base_from_laser: [")));
  core::RobotModel recorded;
  recorded.wheel_track_m = found->calibration.assumed.wheels.track_m;
  const auto setup = ReadSetup(ros, recorded);
  ASSERT_TRUE(setup.ok()) << setup.status();
  EXPECT_NEAR(setup->wheels.track_m,
              found->calibration.Of(Quantity::kTrack).value, 2e-4);
  EXPECT_NEAR(setup->wheels.right_scale,
              found->calibration.Of(Quantity::kRightScale).value, 6e-5);
  EXPECT_NEAR(setup->laser_delay_s,
              found->calibration.Of(Quantity::kLaserDelay).value, 6e-5);
}

TEST_F(CalibrateRun, SaysThatThereAreNoPictures) {
  const auto found = RunCalibration({.log = log_, .with_camera = true}, {});
  EXPECT_EQ(found.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(found.status().message(), HasSubstr("no pictures with depth"));
}

TEST_F(CalibrateRun, LeavesFilesThatItCannotReadAlone) {
  EXPECT_FALSE(RunCalibration({.log = folder_.Path("none.tlog")}, {}).ok());
  EXPECT_FALSE(RunCalibration({.log = log_, .robot = "nobody"}, {}).ok());
  const std::string broken = folder_.Path("broken.yaml");
  ASSERT_TRUE(base::WriteFileAtomically(broken, "wheels: 3\n").ok());
  const auto written = RunCalibration({.log = log_, .write = broken}, {});
  EXPECT_THAT(written.status().message(), HasSubstr("wheels"));
  EXPECT_EQ(*base::ReadFile(broken), "wheels: 3\n");
}

}  // namespace
}  // namespace treeline::calibrate_app

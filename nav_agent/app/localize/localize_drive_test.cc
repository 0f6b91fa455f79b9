#include "nav_agent/app/localize/localize_drive.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::localize_app {
namespace {

using testing::HasSubstr;

base::MonotonicTime At(int ms) {
  return base::MonotonicTime(std::chrono::milliseconds(ms));
}

core::RangeSensorInfo Laser() {
  return {.angle_min_rad = -1,
          .angle_increment_rad = 1,
          .beams = 3,
          .range_min_m = 0.1,
          .range_max_m = 10,
          .beam_interval_s = 0.005,
          .scan_interval_s = 0.1};
}

core::LaserScan ScanAt(int ms, size_t beams = 3) {
  return {.stamp = At(ms),
          .ranges_m = std::vector<float>(beams, 2.0f),
          .intensities = {}};
}

// Straight on at 1 m/s.
core::BaseReading ReadingAt(int ms) {
  return {.stamp = At(ms),
          .left_wheel_m = 0.001 * ms,
          .right_wheel_m = 0.001 * ms,
          .forward_mps = 1};
}

class LogFile {
 public:
  explicit LogFile(const std::string& records)
      : path_(absl::StrCat(testing::TempDir(), "/localize_drive_", getpid())) {
    EXPECT_TRUE(
        base::WriteFileAtomically(path_, recording::AgentLogHeader() + records)
            .ok());
  }
  ~LogFile() { unlink(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(ReadDrive, PutsScansWhereOdometryAndTruthWere) {
  std::string records = recording::EncodeLogRecord(core::RobotModel()) +
                        recording::EncodeLogRecord(Laser());
  for (int ms = 0; ms <= 1000; ms += 10) {
    records += recording::EncodeLogRecord(ReadingAt(ms));
    records += recording::EncodeLogRecord(recording::LogTruePose{
        .stamp = At(ms),
        .world_from_base = {.rotation = {},
                            .translation = {5 + 0.001 * ms, 0, 0}}});
    if (ms % 100 == 50) records += recording::EncodeLogRecord(ScanAt(ms - 37));
  }
  const LogFile file(records);
  const auto drive = ReadDrive(file.path());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ(drive->scans.size(), 10u);
  EXPECT_TRUE(drive->has_tilt);
  EXPECT_EQ(drive->base_from_laser, core::RobotModel().base_from_laser);
  EXPECT_EQ(drive->refused_scans, 0);
  // The middle of the scan is 5 ms behind its first beam.
  EXPECT_NEAR(drive->scans[1].odom_from_base.translation.x, 0.118, 1e-6);
  ASSERT_TRUE(drive->scans[1].world_from_base.has_value());
  EXPECT_NEAR(drive->scans[1].world_from_base->translation.x, 5.118, 1e-6);
}

TEST(ReadDrive, ScansAndWheelsOfOneMomentNeedNothingBetween) {
  core::RangeSensorInfo laser = Laser();
  laser.beam_interval_s = 0;
  std::string records = recording::EncodeLogRecord(laser);
  for (int ms = 0; ms <= 30'000; ms += 3'000) {
    records += recording::EncodeLogRecord(ReadingAt(ms));
    records += recording::EncodeLogRecord(ScanAt(ms));
  }
  // Of a moment in which nobody read the wheels.
  records += recording::EncodeLogRecord(ScanAt(31'000));
  records += recording::EncodeLogRecord(ReadingAt(33'000));
  const LogFile file(records);
  const auto drive = ReadDrive(file.path());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ(drive->scans.size(), 11u);
  EXPECT_EQ(drive->refused_scans, 1);
}

TEST(ReadDrive, CountsWhatItLeavesOut) {
  std::string records = recording::EncodeLogRecord(Laser());
  for (int ms = 0; ms <= 1000; ms += 10) {
    records += recording::EncodeLogRecord(ReadingAt(ms));
  }
  // A clock that jumps back, what is not a number, too few beams, the same scan
  // again, one that no odometry is near to, and half of a record.
  records += recording::EncodeLogRecord(ReadingAt(500));
  core::BaseReading broken = ReadingAt(1010);
  broken.left_wheel_m = std::numeric_limits<double>::quiet_NaN();
  records += recording::EncodeLogRecord(broken);
  records += recording::EncodeLogRecord(ScanAt(200));
  records += recording::EncodeLogRecord(ScanAt(300, 2));
  records += recording::EncodeLogRecord(ScanAt(200));
  records += recording::EncodeLogRecord(ScanAt(100));
  records += recording::EncodeLogRecord(ScanAt(400));
  records += recording::EncodeLogRecord(ScanAt(5000));
  records += recording::EncodeLogRecord(ScanAt(6000)).substr(0, 40);
  const LogFile file(records);
  const auto drive = ReadDrive(file.path());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ(drive->scans.size(), 2u);
  EXPECT_EQ(drive->refused_readings, 2);
  EXPECT_EQ(drive->refused_scans, 4);
  EXPECT_EQ(drive->damaged_bytes, 40);
  EXPECT_FALSE(drive->scans[0].world_from_base.has_value());
}

TEST(ReadDrive, SaysWhatIsMissing) {
  {
    const LogFile file(recording::EncodeLogRecord(ReadingAt(0)));
    EXPECT_THAT(ReadDrive(file.path()).status().message(),
                HasSubstr("names no laser scanner"));
  }
  {
    const LogFile file(recording::EncodeLogRecord(Laser()) +
                       recording::EncodeLogRecord(ScanAt(0)));
    EXPECT_THAT(ReadDrive(file.path()).status().message(),
                HasSubstr("no usable wheel reading (0 were refused)"));
  }
  {
    const LogFile file(recording::EncodeLogRecord(Laser()) +
                       recording::EncodeLogRecord(ReadingAt(0)) +
                       recording::EncodeLogRecord(ScanAt(0, 7)));
    EXPECT_THAT(ReadDrive(file.path()).status().message(),
                HasSubstr("no usable scan (1 were refused)"));
  }
  EXPECT_EQ(ReadDrive("/nowhere/drive.tlog").status().code(),
            absl::StatusCode::kNotFound);
}

TEST(DriveOf, IsOnLevelGround) {
  recording::LaserLog log;
  log.laser = Laser();
  log.base_from_laser = {.translation = {0.25, 0}, .yaw_rad = 0.1};
  log.scans.push_back({.stamp = {},
                       .odom_from_base = {.translation = {1, 2}, .yaw_rad = 3},
                       .ranges_m = {1, 2, 3}});
  const RecordedDrive drive = DriveOf(log);
  EXPECT_FALSE(drive.has_tilt);
  ASSERT_EQ(drive.scans.size(), 1u);
  EXPECT_EQ(drive.scans[0].odom_from_base, log.scans[0].odom_from_base);
  EXPECT_EQ(drive.scans[0].level_from_base, geometry::Rotation3());
  const geometry::Vec3 ahead = drive.base_from_laser * geometry::Vec3{1, 0, 0};
  EXPECT_NEAR(ahead.x, 0.25 + std::cos(0.1), 1e-12);
  EXPECT_NEAR(ahead.y, std::sin(0.1), 1e-12);
}

}  // namespace
}  // namespace treeline::localize_app

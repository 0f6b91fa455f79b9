#include "nav_agent/app/map/calibrated_log.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/dataset/text_formats.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/app/map/map_from_log.h"
#include "nav_agent/calibration/testing_drive.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::map_app {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// A drive of a robot whose log has its laser 8 cm behind of where it is, and
// stamped 40 ms late.
class CalibratedLogTest : public ::testing::Test {
 protected:
  void Record(double seconds) {
    calibration::TestDriveOptions drive;
    drive.truth.base_from_laser = {{0.30, 0}, 0};
    drive.truth.laser_delay_s = 0.04;
    drive.assumed.base_from_laser = {{0.22, 0}, 0};
    drive.seconds = seconds;
    const base::SteadyClock clock;
    const auto writer = recording::AgentLogWriter::Open(log_, false, clock);
    ASSERT_TRUE(writer.ok());
    for (const auto& entry : calibration::TestDriveEntries(drive)) {
      ASSERT_TRUE((*writer)->Write(entry).ok());
    }
  }

  base::TestingFolder folder_;
  std::string log_ = folder_.Path("drive.tlog");
};

TEST_F(CalibratedLogTest, IsTheDriveWithTheLaserWhereItIs) {
  Record(75);
  std::string path;
  {
    const auto calibrated = CalibratedLog::Make(log_, "", {});
    ASSERT_TRUE(calibrated.ok()) << calibrated.status();
    path = calibrated->path();
    EXPECT_THAT(calibrated->summary(), HasSubstr("laser x"));
    ASSERT_TRUE(calibrated->noise().has_value());
    EXPECT_GT(calibrated->noise()->turn_from_turn, 0);
    EXPECT_NEAR(std::chrono::duration<double>(calibrated->scan_delay()).count(),
                0.04, 0.01);
    const auto map = mapping::MapRecording(path, {});
    ASSERT_TRUE(map.ok()) << map.status();
    EXPECT_NEAR(map->base_from_laser.translation.x, 0.30, 0.02);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(CalibratedLogTest, TheTrajectoryHasTheTimesOfTheRecordedScans) {
  Record(75);
  const auto calibrated = CalibratedLog::Make(log_, "", {});
  ASSERT_TRUE(calibrated.ok()) << calibrated.status();
  MapLogOptions options;
  options.drive.slam.synchronous = true;
  options.map.overwrite = true;
  const auto first_time = [&](const std::string& log,
                              recording::RecordingTime::duration delay) {
    options.map.folder = folder_.Path("map");
    options.scan_delay = delay;
    const auto mapped = MapLog(log, options);
    EXPECT_TRUE(mapped.ok()) << mapped.status();
    const std::string file = options.map.folder + "/trajectory.txt";
    const auto text = base::ReadFile(file);
    EXPECT_TRUE(text.ok()) << text.status();
    const auto poses = dataset::ParseTimedPoses(*text, file);
    EXPECT_TRUE(poses.ok()) << poses.status();
    return poses->front().time;
  };
  EXPECT_NEAR(static_cast<double>(
                  first_time(log_, {}) -
                  first_time(calibrated->path(), calibrated->scan_delay())),
              0, 1e3);
}

TEST_F(CalibratedLogTest, ADriveThatShowsNothingIsRefused) {
  Record(4);
  const absl::Status status = CalibratedLog::Make(log_, "", {}).status();
  EXPECT_THAT(std::string(status.message()), StartsWith("--calibrate: "));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("drive for some minutes"));
}

}  // namespace
}  // namespace treeline::map_app

// The readers on real recordings (TREELINE_DATA).
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/recording/laser_log.h"
#include "nav_agent/recording/relations.h"

namespace treeline::recording {
namespace {

using ::testing::SizeIs;

// "" if it is not there.
std::string Folder(const std::string& name) {
  const char* data = std::getenv("TREELINE_DATA");
  const std::string folder =
      std::string(data != nullptr ? data : TREELINE_DEFAULT_DATA) + "/" + name;
  return std::filesystem::is_directory(folder) ? folder : "";
}

TEST(LaserRecordings, IntelResearchLab) {
  const std::string folder = Folder("laser-intel");
  if (folder.empty()) GTEST_SKIP() << "no laser-intel in TREELINE_DATA";
  const auto log = ReadLaserLog(folder + "/raw.json");
  ASSERT_TRUE(log.ok()) << log.status();
  EXPECT_THAT(log->scans, SizeIs(910));
  EXPECT_EQ(log->laser.beams, 180);
  EXPECT_EQ(FormatRecordingTime(log->scans[0].stamp), "976052890.244111");
  EXPECT_FLOAT_EQ(log->scans[0].ranges_m[1], 1.08F);
  int none = 0;
  for (const RecordedScan& scan : log->scans) {
    for (const float range_m : scan.ranges_m)
      none += range_m == core::kNoReturn;
  }
  EXPECT_EQ(none, 4172);
  const auto relations = ReadRelations(folder + "/intel.relations");
  ASSERT_TRUE(relations.ok()) << relations.status();
  EXPECT_THAT(*relations, SizeIs(2984));
}

TEST(LaserRecordings, WeanHall) {
  const std::string folder = Folder("laser-wean");
  if (folder.empty()) GTEST_SKIP() << "no laser-wean in TREELINE_DATA";
  constexpr size_t kScans[] = {713, 2251, 1241};
  for (int i = 0; i < 3; ++i) {
    const auto log =
        ReadLaserLog(folder + "/robotdata" + std::to_string(i + 1) + ".log.gz");
    ASSERT_TRUE(log.ok()) << log.status();
    EXPECT_THAT(log->scans, SizeIs(kScans[i]));
    EXPECT_FALSE(log->odometry.empty());
    EXPECT_EQ(log->laser.beams, 180);
    // 25 cm ahead of the centre, says the recording's description.
    EXPECT_NEAR(log->base_from_laser.translation.x, 0.25, 0.005);
    EXPECT_NEAR(log->base_from_laser.translation.y, 0, 0.005);
  }
}

}  // namespace
}  // namespace treeline::recording

#include "nav_agent/app/doctor/doctor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace treeline::doctor_app {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

HeardLaser GoodLaser() {
  HeardLaser heard;
  heard.info = {.angle_min_rad = -1,
                .angle_increment_rad = 0.01,
                .beams = 4,
                .range_min_m = 0.1,
                .range_max_m = 30,
                .beam_interval_s = 0,
                .scan_interval_s = 0.025};
  heard.seconds = 1;
  for (int i = 0; i < 40; ++i) {
    heard.scans.push_back({.stamp = {},
                           .ranges_m = {1, 2, 3, core::kNoReturn},
                           .intensities = {}});
  }
  return heard;
}

TEST(Doctor, AGoodLaserIsFine) {
  EXPECT_EQ(WorstOf(JudgeLaser(GoodLaser())), Verdict::kOk);
}

TEST(Doctor, ASilentLaserFailsWithItsCause) {
  HeardLaser heard;
  heard.health.cause = absl::NotFoundError("/dev/ttyACM0 is not there");
  heard.name = "rear laser";
  const auto findings = JudgeLaser(heard);
  ASSERT_THAT(findings, SizeIs(1));
  EXPECT_THAT(findings[0].what, HasSubstr("rear laser"));
  EXPECT_EQ(findings[0].verdict, Verdict::kFail);
  EXPECT_THAT(findings[0].found, HasSubstr("/dev/ttyACM0"));
  EXPECT_FALSE(findings[0].mend.empty());
}

TEST(Doctor, LasersThatAreSlowBlindOrDirtyAreNamed) {
  HeardLaser slow = GoodLaser();
  slow.scans.resize(20);
  EXPECT_EQ(WorstOf(JudgeLaser(slow)), Verdict::kWarn);
  HeardLaser blind = GoodLaser();
  for (core::LaserScan& scan : blind.scans) {
    scan.ranges_m = {core::kNoReturn, core::kNoReturn, core::kNoReturn, 1};
  }
  EXPECT_EQ(WorstOf(JudgeLaser(blind)), Verdict::kWarn);
  HeardLaser dirty = GoodLaser();
  for (core::LaserScan& scan : dirty.scans)
    scan.ranges_m[0] = core::kInvalidRange;
  EXPECT_EQ(WorstOf(JudgeLaser(dirty)), Verdict::kFail);
}

TEST(Doctor, JudgesTheBase) {
  HeardBase heard;
  heard.seconds = 1;
  heard.readings.resize(50);
  heard.readings.back().battery_v = 72;
  EXPECT_EQ(WorstOf(JudgeBase(heard)), Verdict::kOk);
  heard.readings.back().battery_v = 60;
  EXPECT_EQ(WorstOf(JudgeBase(heard)), Verdict::kWarn);
  heard.readings.back().motors_enabled = false;
  EXPECT_EQ(WorstOf(JudgeBase(heard)), Verdict::kFail);
  EXPECT_EQ(WorstOf(JudgeBase({})), Verdict::kFail);
}

TEST(Doctor, JudgesTheCamera) {
  HeardCamera heard;
  EXPECT_EQ(WorstOf(JudgeCamera(heard)), Verdict::kFail);
  heard.frames = 90;
  heard.seconds = 3;
  heard.depth_share = 0.7;
  heard.brightness = 100;
  EXPECT_EQ(WorstOf(JudgeCamera(heard)), Verdict::kOk);
  heard.brightness = 5;
  EXPECT_THAT(JudgeCamera(heard)[0].mend, HasSubstr("dark"));
  heard.depth_share = 0;
  EXPECT_THAT(JudgeCamera(heard)[0].mend, HasSubstr("depth"));
}

TEST(Doctor, JudgesTheCalibration) {
  calibration::Calibration calibration;
  auto& track =
      calibration.estimates[static_cast<size_t>(calibration::Quantity::kTrack)];
  track = {.value = 0.54, .sigma = 0.003, .is_known = true};
  EXPECT_EQ(JudgeCalibration("a.tlog", calibration).verdict, Verdict::kOk);
  track.value = 0.56;
  const Finding finding = JudgeCalibration("a.tlog", calibration);
  EXPECT_EQ(finding.verdict, Verdict::kWarn);
  EXPECT_THAT(finding.found, HasSubstr("track is 0.5600 m, not 0.5400"));
  EXPECT_THAT(finding.mend, HasSubstr("calibrate a.tlog"));
  // Not known: nothing is said.
  track.is_known = false;
  EXPECT_EQ(JudgeCalibration("a.tlog", calibration).verdict, Verdict::kOk);
  calibration.excess = {.yaw = 1.5, .along = 1.9};
  EXPECT_EQ(JudgeCalibration("a.tlog", calibration).verdict, Verdict::kOk);
  calibration.excess.yaw = 3.2;
  const Finding noisy = JudgeCalibration("a.tlog", calibration);
  EXPECT_EQ(noisy.verdict, Verdict::kWarn);
  EXPECT_THAT(noisy.found, HasSubstr("3.2 times (in yaw) as much"));
  EXPECT_EQ(JudgeCalibration("a.tlog", absl::NotFoundError("no such")).verdict,
            Verdict::kWarn);
}

behavior::NavigatorMap MapOf(int levels, int joins, core::Occupancy occupancy) {
  behavior::NavigatorMap map;
  for (int i = 0; i < levels; ++i) {
    traversability::TraversableLevel level;
    level.grid = core::OccupancyGrid::Filled(4, 4, 0.5, {}, occupancy);
    map.levels.levels.push_back(level);
  }
  map.levels.joins.resize(static_cast<size_t>(joins));
  return map;
}

TEST(Doctor, JudgesMaps) {
  EXPECT_EQ(WorstOf(JudgeMap("m", absl::NotFoundError("no bundle"))),
            Verdict::kFail);
  EXPECT_EQ(WorstOf(JudgeMap("m", MapOf(1, 0, core::Occupancy::kFree))),
            Verdict::kOk);
  EXPECT_EQ(WorstOf(JudgeMap("m", MapOf(1, 0, core::Occupancy::kUnknown))),
            Verdict::kFail);
  EXPECT_EQ(WorstOf(JudgeMap("m", MapOf(2, 0, core::Occupancy::kFree))),
            Verdict::kWarn);
  EXPECT_EQ(WorstOf(JudgeMap("m", MapOf(2, 1, core::Occupancy::kFree))),
            Verdict::kOk);
}

TEST(Doctor, JudgesServers) {
  const auto unreachable =
      JudgeServer("a:1", "house", "1.0", absl::UnavailableError("refused"), 0);
  EXPECT_EQ(WorstOf(unreachable), Verdict::kFail);
  EXPECT_THAT(unreachable[0].mend, HasSubstr("start treeline-server"));
  EXPECT_THAT(JudgeServer("a:1", "house", "1.0",
                          absl::UnimplementedError("what?"), 0)[0]
                  .mend,
              HasSubstr("another version"));
  relocalizer::SceneDescription scene;
  scene.name = "house";
  scene.state = "READY";
  scene.model.emplace();
  scene.model->software_version = "1.0";
  const std::vector<relocalizer::SceneDescription> scenes = {scene};
  EXPECT_EQ(WorstOf(JudgeServer("a:1", "house", "1.0", scenes, 0.01)),
            Verdict::kOk);
  EXPECT_EQ(WorstOf(JudgeServer("a:1", "house", "1.0", scenes, 0.9)),
            Verdict::kWarn);
  const auto missing = JudgeServer("a:1", "barn", "1.0", scenes, 0.01);
  EXPECT_EQ(WorstOf(missing), Verdict::kFail);
  EXPECT_THAT(missing[1].found, HasSubstr("there are: house"));
  const auto other = JudgeServer("a:1", "house", "2.0", scenes, 0.01);
  EXPECT_EQ(WorstOf(other), Verdict::kWarn);
  EXPECT_THAT(other[2].found,
              HasSubstr("trained with 1.0, this robot runs 2.0"));
}

TEST(Doctor, JudgesTheMachine) {
  constexpr uint64_t kGiB = uint64_t{1} << 30;
  EXPECT_EQ(JudgeDisk(".", 50 * kGiB).verdict, Verdict::kOk);
  EXPECT_EQ(JudgeDisk(".", kGiB).verdict, Verdict::kWarn);
  EXPECT_EQ(JudgeDisk(".", uint64_t{1000}).verdict, Verdict::kFail);
  EXPECT_EQ(JudgeDisk("x", absl::NotFoundError("x: no")).verdict,
            Verdict::kFail);
  EXPECT_EQ(JudgeClock(1.8e9, true).verdict, Verdict::kOk);
  EXPECT_EQ(JudgeClock(1.8e9, false).verdict, Verdict::kWarn);
  EXPECT_EQ(JudgeClock(0, true).verdict, Verdict::kFail);
}

TEST(Doctor, WritesJsonWhateverIsInIt) {
  const std::vector<Finding> findings = {{.what = "laser",
                                          .verdict = Verdict::kFail,
                                          .found = "\xff\"",
                                          .mend = "mend it"}};
  const auto json = nlohmann::json::parse(FindingsJson(findings));
  EXPECT_EQ(json["verdict"], "fail");
  EXPECT_EQ(json["findings"][0]["mend"], "mend it");
  EXPECT_THAT(FindingsText(findings), HasSubstr("-> mend it"));
}

}  // namespace
}  // namespace treeline::doctor_app

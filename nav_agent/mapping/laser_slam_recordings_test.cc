// Laser SLAM on real recordings (TREELINE_DATA), beside raw odometry and what
// others made of them. Prints the table of docs/research/laser-slam.md; writes
// the maps into the folder TREELINE_MAPS if that is set.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/mapping/run_laser_slam.h"
#include "nav_agent/mapping/trajectory_score.h"
#include "nav_agent/recording/relations.h"

namespace treeline::mapping {
namespace {

// "" if it is not there.
std::string Folder(const std::string& name) {
  const char* data = std::getenv("TREELINE_DATA");
  const std::string folder =
      std::string(data != nullptr ? data : TREELINE_DEFAULT_DATA) + "/" + name;
  return std::filesystem::is_directory(folder) ? folder : "";
}

std::vector<TrajectoryPose> Recorded(const recording::LaserLog& log) {
  std::vector<TrajectoryPose> trajectory;
  for (const recording::RecordedScan& scan : log.scans) {
    trajectory.push_back(
        {.stamp = scan.stamp, .map_from_base = scan.odom_from_base});
  }
  return trajectory;
}

RelationScore Score(const char* name,
                    const std::vector<TrajectoryPose>& trajectory,
                    const std::vector<recording::PoseRelation>& relations,
                    double max_gap_s) {
  const auto score =
      ScoreRelations(trajectory, relations, {.max_gap_s = max_gap_s});
  EXPECT_TRUE(score.ok()) << score.status();
  constexpr double kDegrees = 180 / std::numbers::pi;
  std::printf("%-28s %5d  %7.4f  %7.4f  %7.4f  %7.3f  %7.3f  %7.3f\n", name,
              score->used, score->translation_m.mean, score->translation_m.rmse,
              score->translation_m.median, score->rotation_rad.mean * kDegrees,
              score->rotation_rad.rmse * kDegrees,
              score->rotation_rad.median * kDegrees);
  return *score;
}

void WriteIfAsked(const core::OccupancyGrid& grid, const std::string& name) {
  const char* folder = std::getenv("TREELINE_MAPS");
  if (folder == nullptr) return;
  const absl::Status written =
      core::WriteMap(grid, std::string(folder) + "/" + name + ".yaml");
  EXPECT_TRUE(written.ok()) << written;
}

void PrintRun(const LaserSlamResult& result) {
  const LaserSlamStatistics& s = result.statistics;
  std::printf(
      "%lld scans, %lld keyscans, %lld unmatched; loops: %lld tried, %lld "
      "accepted, %lld dropped; front end p50 %.2f p99 %.2f max %.2f ms; "
      "%.1f s in all\n",
      static_cast<long long>(s.scans), static_cast<long long>(s.keyscans),
      static_cast<long long>(s.unmatched),
      static_cast<long long>(s.loops.tried),
      static_cast<long long>(s.loops.accepted),
      static_cast<long long>(s.loops.dropped), result.p50_ms, result.p99_ms,
      result.max_ms, result.total_s);
}

TEST(LaserSlamRecordings, IntelIsAtLeastAsGoodAsItsCorrectedLog) {
  const std::string folder = Folder("laser-intel");
  if (folder.empty()) GTEST_SKIP() << "no laser-intel in TREELINE_DATA";
  const auto raw = recording::ReadLaserLog(folder + "/raw.json");
  const auto corrected = recording::ReadLaserLog(folder + "/corrected.json");
  const auto relations = recording::ReadRelations(folder + "/intel.relations");
  ASSERT_TRUE(raw.ok() && corrected.ok() && relations.ok());
  RunLaserSlamOptions options;
  options.slam.synchronous = true;
  const auto ours = RunLaserSlam(*raw, options);
  ASSERT_TRUE(ours.ok()) << ours.status();
  PrintRun(*ours);
  WriteIfAsked(ours->grid, "intel");

  // Most relations are between scans that this recording leaves out: their
  // times are interpolated over up to a metre, the same for all three.
  struct Choice {
    const char* name;
    double max_gap_s;
  };
  std::printf("%-28s %5s  %7s  %7s  %7s  %7s  %7s  %7s\n", "", "n", "t mean",
              "t rmse", "t med", "r mean", "r rmse", "r med");
  for (const Choice& choice :
       {Choice{"at scans", 0.0}, Choice{"within 0.1 s", 0.1},
        Choice{"all", 1e9}}) {
    const std::string name = choice.name;
    Score((name + ", odometry").c_str(), Recorded(*raw), *relations,
          choice.max_gap_s);
    const RelationScore theirs =
        Score((name + ", corrected.json").c_str(), Recorded(*corrected),
              *relations, choice.max_gap_s);
    const RelationScore our =
        Score((name + ", Treeline").c_str(), ours->trajectory, *relations,
              choice.max_gap_s);
    EXPECT_LE(our.translation_m.mean, theirs.translation_m.mean) << name;
    EXPECT_LE(our.translation_m.rmse, theirs.translation_m.rmse) << name;
    // Where times are interpolated, a turn between two scans is off by up to
    // 46 degrees for both of them, and covers what is to be compared.
    const double slack = choice.max_gap_s > 0 ? 1.01 : 1.0;
    EXPECT_LE(our.rotation_rad.mean, slack * theirs.rotation_rad.mean) << name;
    EXPECT_LE(our.rotation_rad.rmse, slack * theirs.rotation_rad.rmse) << name;
  }
}

TEST(LaserSlamRecordings, WeanHallIsMapped) {
  const std::string folder = Folder("laser-wean");
  if (folder.empty()) GTEST_SKIP() << "no laser-wean in TREELINE_DATA";
  for (int i = 1; i <= 3; ++i) {
    const auto log = recording::ReadLaserLog(folder + "/robotdata" +
                                             std::to_string(i) + ".log.gz");
    ASSERT_TRUE(log.ok()) << log.status();
    const auto result = RunLaserSlam(*log, RunLaserSlamOptions{});
    ASSERT_TRUE(result.ok()) << result.status();
    PrintRun(*result);
    WriteIfAsked(result->grid, "wean" + std::to_string(i));
    // There is no ground truth; but scans must match those before them.
    EXPECT_LT(50 * result->statistics.unmatched, result->statistics.scans);
  }
}

}  // namespace
}  // namespace treeline::mapping

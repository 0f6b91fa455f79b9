// RGB-D SLAM on real recordings (TREELINE_DATA). Prints the lines of
// docs/research/rgbd-slam.md.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "common/dataset/dataset.h"
#include "common/dataset/trajectory_error.h"
#include "gtest/gtest.h"
#include "nav_agent/rgbd_slam/run_rgbd_slam.h"

namespace treeline::rgbd_slam {
namespace {

// "" if it is not there.
std::string Folder(const std::string& name) {
  const char* data = std::getenv("TREELINE_DATA");
  const std::string folder =
      std::string(data != nullptr ? data : TREELINE_DEFAULT_DATA) + "/" + name;
  return std::filesystem::is_directory(folder) ? folder : "";
}

dataset::TrajectoryScore Score(const char* name,
                               const dataset::Dataset& dataset) {
  const auto result = RunRgbdSlam(dataset, {});
  EXPECT_TRUE(result.ok()) << result.status();
  if (!result.ok()) return {};
  std::vector<dataset::TimedPose> reference;
  for (int i = 0; i < dataset.size(); ++i) {
    if (!dataset.frame(i).world_from_camera) continue;
    reference.push_back({result->times[static_cast<size_t>(i)],
                         *dataset.frame(i).world_from_camera});
  }
  const auto score = dataset::ScoreTrajectory(TrajectoryOf(*result), reference);
  EXPECT_TRUE(score.ok()) << score.status();
  if (!score.ok()) return {};
  const RgbdSlamStatistics& statistics = result->statistics;
  std::printf(
      "%s: %d of %d tracked, %d relocalized, %d loops, %d keyframes; ATE %.4f "
      "m, RPE %.4f m/s; tracking %.1f ms (p99 %.1f)\n",
      name, statistics.tracked, statistics.frames, statistics.relocalized,
      statistics.loops, statistics.keyframes, score->absolute.position_m.rmse,
      score->relative_m.rmse, result->tracking_p50_ms, result->tracking_p99_ms);
  EXPECT_EQ(statistics.lost, 0);
  return *score;
}

TEST(RgbdSlamOnRecordings, FollowsFr1Rpy) {
  for (const char* part : {"train", "test"}) {
    const std::string folder = Folder(std::string("tum-fr1-rpy/") + part);
    if (folder.empty()) GTEST_SKIP() << "no tum-fr1-rpy; set TREELINE_DATA";
    const auto dataset = dataset::Dataset::Open({.uri = "tum:" + folder});
    ASSERT_TRUE(dataset.ok()) << dataset.status();
    // About 0.02 m is published for ORB-SLAM2 on the whole of it.
    EXPECT_LT(Score(part, *dataset).absolute.position_m.rmse, 0.03);
  }
}

TEST(RgbdSlamOnRecordings, FollowsTheFirstFramesOfRedKitchen) {
  const std::string folder = Folder("7scenes-redkitchen");
  if (folder.empty()) GTEST_SKIP() << "no 7scenes-redkitchen";
  const auto dataset = dataset::Dataset::Open(
      {.uri = "7scenes:" + folder, .pose_file = folder + "/poses-sfm.txt"});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  // Frames 0 to 99, a gap of 20, 120 to 179, every other one.
  std::vector<int> frames;
  for (int i = 0; i < 160; i += 2) frames.push_back(i);
  EXPECT_LT(
      Score("redkitchen", dataset->Subset(frames)).absolute.position_m.rmse,
      0.03);
}

}  // namespace
}  // namespace treeline::rgbd_slam

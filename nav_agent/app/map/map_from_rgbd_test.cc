// A recording of an RGB-D camera becomes a map bundle.
#include "nav_agent/app/map/map_from_rgbd.h"

#include <unistd.h>

#include <filesystem>
#include <string>

#include "common/dataset/dataset.h"
#include "gtest/gtest.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "simulation/recorder/recorder.h"

namespace treeline::map_app {
namespace {

class MapRgbdTest : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const std::string folder_ =
      testing::TempDir() + "/map-rgbd-" + std::to_string(getpid());
};

TEST_F(MapRgbdTest, TheMapIsUprightAndItsKeyframesAreARecording) {
  recorder::RecordOptions recording;
  recording.folder = folder_ + "/room";
  recording.format = recorder::RecordFormat::kTum;
  recording.frames = 6;
  recording.rate_hz = 15;
  ASSERT_TRUE(recorder::RecordWorld(recording, {}, {}).ok());
  const auto dataset =
      dataset::Dataset::Open({.uri = "tum:" + recording.folder});
  ASSERT_TRUE(dataset.ok()) << dataset.status();

  MapRgbdOptions options;
  options.map.folder = folder_ + "/map";
  options.map.keyframe_m = 0;
  const auto result = MapRgbd(*dataset, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->slam.statistics.tracked, 6);
  EXPECT_EQ(result->summary.keyframes, 6);

  // Up is where the recording's world has it, as well as a level surface of
  // some hundred noisy points can tell: a degree.
  ASSERT_EQ(result->map_from_camera.size(), 6U);
  const geometry::Rigid3 world_from_map =
      *dataset->frame(0).world_from_camera *
      result->map_from_camera[0].world_from_camera.Inverse();
  EXPECT_GT((world_from_map.rotation * geometry::Vec3{0, 0, 1}).z, 0.9998);

  const auto manifest = map_bundle::ReadMapBundleManifest(options.map.folder);
  ASSERT_TRUE(manifest.ok()) << manifest.status();
  EXPECT_EQ(manifest->trajectory_of, "camera");
  const auto again = dataset::Dataset::Open(
      {.uri = "7scenes:" + options.map.folder + "/keyframes"});
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->size(), 6);
}

}  // namespace
}  // namespace treeline::map_app

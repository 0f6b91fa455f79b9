#include "nav_agent/traversability/level_files.h"

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/traversability/testing_scene.h"

namespace treeline::traversability {
namespace {

using testing::HasSubstr;

class LevelFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / "level_files_test";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string Path(const std::string& name) const {
    return (folder_ / name).string();
  }

  std::filesystem::path folder_;
};

Scene MakeStep() {
  Scene scene = Scene::WithFloor(4, 3);
  scene.AddBox(BlockKind::kGround, {2, 0}, {4, 3}, 0.513);
  return scene;
}

TEST_F(LevelFilesTest, ACommandWritesMapsLayersAndPictures) {
  const octree::VoxelMap voxels = Voxelize(MakeStep());
  ASSERT_TRUE(octree::WriteOctree(voxels, Path("map.bt")).ok());
  TraversabilityCommand command;
  command.octomap_path = Path("map.bt");
  command.output_folder = Path("out");
  const absl::StatusOr<TraversabilitySummary> summary =
      RunTraversability(command);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->levels, 1);
  EXPECT_GT(summary->free_cells, 4000);

  const absl::StatusOr<core::OccupancyGrid> grid =
      core::ReadMap(Path("out/level-0.yaml"));
  ASSERT_TRUE(grid.ok()) << grid.status();
  const absl::StatusOr<TraversableMap> map = ExtractTraversableMap(voxels);
  EXPECT_EQ(grid->cells, map->levels[0].grid.cells);

  const auto layer = [this](const std::string& name) {
    return *core::ParsePgm(
        *base::ReadFile(Path("out/level-0-" + name + ".pgm")), name);
  };
  // Rows from the top: the left column's middle is floor, the right one's
  // 0.5 m higher (in mm), level, and open above.
  const size_t left = 30 * 80 + 10;
  const size_t right = 30 * 80 + 70;
  const core::GreyPicture height = layer("height");
  EXPECT_EQ(height.max_value, 65535);
  EXPECT_EQ(height.values[left], 1);
  EXPECT_NEAR(height.values[right], 501, 1);
  EXPECT_EQ(layer("slope").values[left], 1);
  EXPECT_EQ(layer("slope").values[30 * 80 + 40], 15709);  // pi/2
  EXPECT_EQ(layer("clearance").values[left], 65535);
  EXPECT_THAT(*base::ReadFile(Path("out/layers.yaml")),
              HasSubstr("slope: {unit: 0.0001, offset: 0, quantity: rad}"));
  const absl::StatusOr<image::ColorImage> picture =
      image::DecodeColor(*base::ReadFile(Path("out/level-0.png")));
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture->width, 80);
  EXPECT_EQ(picture->rgb[3 * left], 255);  // white
}

TEST_F(LevelFilesTest, CommandsWithoutGroundOrWithBadFilesSayWhy) {
  TraversabilityCommand command;
  EXPECT_THAT(std::string(RunTraversability(command).status().message()),
              HasSubstr("no OctoMap is named"));
  command.octomap_path = Path("empty.bt");
  command.output_folder = Path("out");
  EXPECT_EQ(RunTraversability(command).status().code(),
            absl::StatusCode::kNotFound);
  ASSERT_TRUE(octree::WriteOctree(*octree::VoxelMap::Make(0.05, {}, {}),
                                  command.octomap_path)
                  .ok());
  EXPECT_THAT(std::string(RunTraversability(command).status().message()),
              HasSubstr("empty.bt: the OctoMap has no occupied voxel"));
  command.occupied_threshold = 1;
  EXPECT_EQ(RunTraversability(command).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::traversability

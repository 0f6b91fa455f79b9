#include "nav_agent/mapping/grid_mapping.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

TEST(GridMapping, MarksARoom) {
  std::vector<TestWall> walls;
  AddBox({-2, -1.5}, {2, 1.5}, &walls);
  const core::RangeSensorInfo laser = TestLaser(10);
  std::vector<std::vector<float>> ranges_m;
  std::vector<GridScan> scans;
  const std::vector<geometry::Rigid2> poses = {
      {{0.1, 0.2}, 0}, {{0.1, 0.2}, 1.5}, {{0.1, 0.2}, 3.1}, {{0, 0}, 4.6}};
  for (const geometry::Rigid2& pose : poses) {
    ranges_m.push_back(CastScan(walls, pose, laser, 0, 1));
  }
  for (size_t i = 0; i < poses.size(); ++i) {
    scans.push_back({.map_from_laser = poses[i], .ranges_m = ranges_m[i]});
  }
  const auto grid = MapGrid(scans, laser, {.min_beams = 1});
  ASSERT_TRUE(grid.ok()) << grid.status();
  int free = 0;
  int occupied = 0;
  for (const core::Occupancy cell : grid->cells) {
    free += cell == core::Occupancy::kFree ? 1 : 0;
    occupied += cell == core::Occupancy::kOccupied ? 1 : 0;
  }
  // 80 x 60 cells of 5 cm; walls on 280 of them, seen by a beam a degree.
  EXPECT_NEAR(free, 80 * 60, 0.06 * 80 * 60);
  EXPECT_GT(occupied, 200);
  EXPECT_LT(occupied, 340);
  EXPECT_EQ(grid->At(grid->CellOf({0, 0})), core::Occupancy::kFree);
  EXPECT_EQ(grid->At(grid->CellOf({0, 1.7})), core::Occupancy::kUnknown);
}

TEST(GridMapping, ForgetsWhatPassedBy) {
  const core::RangeSensorInfo laser = {
      .angle_increment_rad = 0.01, .beams = 1, .range_max_m = 10};
  const std::vector<float> wall = {4.0F};
  const std::vector<float> person = {2.0F};
  std::vector<GridScan> scans(9, {.map_from_laser = {}, .ranges_m = wall});
  scans.push_back({.map_from_laser = {}, .ranges_m = person});
  const auto grid = MapGrid(scans, laser, {});
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->At(grid->CellOf({2.001, 0.001})), core::Occupancy::kFree);
  EXPECT_EQ(grid->At(grid->CellOf({4.001, 0.001})), core::Occupancy::kOccupied);
}

TEST(GridMapping, RefusesWhatIsNotSane) {
  const core::RangeSensorInfo laser = TestLaser(10);
  const std::vector<float> blind(181, core::kInvalidRange);
  const std::vector<float> few(3, 1.0F);
  GridScan scan = {.map_from_laser = {}, .ranges_m = blind};
  EXPECT_THAT(std::string(MapGrid({&scan, 1}, laser, {}).status().message()),
              testing::HasSubstr("are ranges in metres?"));
  scan.ranges_m = few;
  EXPECT_FALSE(MapGrid({&scan, 1}, laser, {}).ok());
  const std::vector<float> seen(181, 3.0F);
  scan.ranges_m = seen;
  EXPECT_FALSE(MapGrid({&scan, 1}, laser, {.resolution_m = 0}).ok());
  EXPECT_EQ(MapGrid({&scan, 1}, laser, {.resolution_m = 1e-5}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace treeline::mapping

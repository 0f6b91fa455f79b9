#include "nav_agent/planning/freed_planner.h"

#include <memory>
#include <stop_token>

#include "gtest/gtest.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline::planning {
namespace {

core::LevelPose At(double x_m, double y_m) {
  return {.map_from_base = {.translation = {x_m, y_m}, .yaw_rad = 0},
          .place = {}};
}

// A corridor 1.2 m wide, with something in its middle.
class FreedPlannerTest : public testing::Test {
 protected:
  FreedPlannerTest() {
    std::vector<std::string> rows = RoomRows(60, 14);
    for (size_t y = 4; y < 11; ++y) rows[y][30] = '#';
    planner_ = *MakeGlobalPlanner(DrawnMap(rows), core::RobotModel(), {});
  }
  PlanResult Plan() const {
    return *planner_->Plan(request_, {.max_iterations = 2000},
                           std::stop_token());
  }
  void Free(int from_x, int to_x) {
    std::vector<traversability::FreedCells::Cell> cells;
    for (int y = 0; y < 28; ++y) {
      for (int x = from_x; x < to_x; ++x) {
        if (y < 2 || y >= 26) continue;
        cells.push_back({.level = 0, .cell = {x, y}, .ground_m = 0.025F});
      }
    }
    request_.freed = std::make_shared<const traversability::FreedCells>(cells);
  }

  PlanRequest request_ = {.start = At(1, 0.7), .goal = At(5, 0.7), .seed = 1};
  std::unique_ptr<GlobalPlanner> planner_;
};

TEST_F(FreedPlannerTest, LeadsOverWhatIsGone) {
  EXPECT_EQ(Plan().failure, core::NavigationCause::kNoPath);
  Free(60, 62);
  const PlanResult over = Plan();
  ASSERT_EQ(over.failure, core::NavigationCause::kNone);
  EXPECT_NEAR(over.length_m, 4, 0.05);
  EXPECT_NEAR(over.path.back().place.height_m, 0.025, 1e-6);
  // Nothing of it is remembered.
  request_.freed = nullptr;
  EXPECT_EQ(Plan().failure, core::NavigationCause::kNoPath);
}

TEST_F(FreedPlannerTest, APartThatIsTooNarrowIsNoWay) {
  Free(60, 61);
  EXPECT_EQ(Plan().failure, core::NavigationCause::kNoPath);
}

TEST_F(FreedPlannerTest, CellsOfAnotherMapAreRefused) {
  request_.freed = std::make_shared<const traversability::FreedCells>(
      std::vector<traversability::FreedCells::Cell>{
          {.level = 3, .cell = {1, 1}, .ground_m = 0}});
  EXPECT_FALSE(
      planner_->Plan(request_, {.max_iterations = 10}, std::stop_token()).ok());
}

// What is kept out of stays so.
TEST_F(FreedPlannerTest, ZonesAreNotFreed) {
  Free(60, 62);
  traversability::TraversableMap map;
  map.levels.push_back(DrawnLevel(RoomRows(60, 14), 2, 0));
  const zones::Zone zone = {
      .name = "door",
      .kind = zones::ZoneKind::kKeepOut,
      .level = 0,
      .corners_in_map = {{2.9, 0.1}, {3.2, 0.1}, {3.2, 1.3}, {2.9, 1.3}}};
  request_.zones = *zones::ZoneMap::Make(map, std::vector{zone}, {}, 1);
  EXPECT_EQ(Plan().failure, core::NavigationCause::kZone);
}

}  // namespace
}  // namespace treeline::planning

#include "nav_agent/planning/global_planner.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "gmock/gmock.h"
#include "nav_agent/planning/plan_frame.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline {
namespace {

constexpr double kPi = std::numbers::pi;

std::unique_ptr<GlobalPlanner> Planner(
    std::shared_ptr<const NavigationMap> map,
    const GlobalPlannerOptions& options = {}) {
  auto planner = MakeGlobalPlanner(std::move(map), RobotModel(), options);
  EXPECT_TRUE(planner.ok()) << planner.status();
  return *std::move(planner);
}

LevelPose At(double x, double y, double yaw_rad = 0, int level = 0) {
  return {.map_from_base = {.translation = {x, y}, .yaw_rad = yaw_rad},
          .place = {.level = level, .height_m = 0}};
}

PlanResult PlanOf(const GlobalPlanner& planner, const PlanRequest& request,
                  int iterations = 3000) {
  const auto result = planner.Plan(request, {.max_iterations = iterations}, {});
  EXPECT_TRUE(result.ok()) << result.status();
  return result.value_or(PlanResult());
}

// Whether the real footprint is clear of all blocked cells at every pose, and
// in between, in steps of a few millimetres.
void ExpectClear(const NavigationMap& map, const PlanResult& result) {
  const auto ground = std::make_shared<const GroundIndex>(
      std::make_shared<const NavigationMap>(map));
  const DriveSpace space(ground, Footprint::Of(RobotModel(), 0.0), {});
  const Rigid2 grid_from_map = map.grid(0).map_from_grid.Inverse();
  for (size_t i = 1; i < result.path.size(); ++i) {
    const Rigid2 from = grid_from_map * result.path[i - 1].map_from_base;
    const Rigid2 to = grid_from_map * result.path[i].map_from_base;
    for (int k = 0; k <= 20; ++k) {
      const double t = k / 20.0;
      const Vec2 at =
          from.translation + t * (to.translation - from.translation);
      ASSERT_TRUE(
          space.Fits({at, result.path[i - 1].place.level}, from.yaw_rad))
          << "pose " << i << " of " << result.path.size() << " at (" << at.x
          << ", " << at.y << ")";
    }
    EXPECT_TRUE(space.CanTurn({to.translation, result.path[i].place.level},
                              from.yaw_rad, to.yaw_rad));
  }
}

// A room of 8 x 5 m with a wall across, and a door of width_dm in it.
std::shared_ptr<const NavigationMap> TwoRooms(int width_dm) {
  std::vector<std::string> rows = RoomRows(80, 50);
  Fill(rows, 40, 42, 1, 49, '#');
  Fill(rows, 40, 42, 20, 20 + width_dm, '.');
  return DrawnMap(rows);
}

TEST(GlobalPlannerTest, StraightWayInAnEmptyRoomIsStraight) {
  const auto map = DrawnMap(RoomRows(60, 40));
  const PlanResult result =
      PlanOf(*Planner(map), {.start = At(1, 2), .goal = At(5, 2, kPi / 2)});
  ASSERT_EQ(result.failure, NavigationCause::kNone) << result.why;
  EXPECT_NEAR(result.length_m, 4, 0.001);
  EXPECT_EQ(result.path.front().map_from_base, At(1, 2).map_from_base);
  // The surface is half a voxel above the layer.
  EXPECT_NEAR(result.path.front().place.height_m, 0.025, 1e-6);
  EXPECT_NEAR(result.path.back().map_from_base.yaw_rad, kPi / 2, 1e-9);
  ExpectClear(*map, result);
}

TEST(GlobalPlannerTest, PassesDoorsThatTheFootprintJustFits) {
  for (const int width_dm : {8, 9}) {
    const auto map = TwoRooms(width_dm);
    const auto planner = Planner(map);
    for (uint64_t seed = 0; seed < 20; ++seed) {
      const PlanResult result = PlanOf(*planner, {.start = At(1, 4, kPi / 2),
                                                  .goal = At(7, 4, -kPi / 2),
                                                  .blockages = {},
                                                  .seed = seed});
      ASSERT_EQ(result.failure, NavigationCause::kNone) << result.why;
      ExpectClear(*map, result);
      EXPECT_LT(result.length_m, 9.0);
    }
  }
}

}  // namespace
}  // namespace treeline

#include "nav_agent/planning/global_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "nav_agent/planning/plan_frame.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline::planning {
namespace {

constexpr double kPi = std::numbers::pi;

std::unique_ptr<GlobalPlanner> Planner(
    std::shared_ptr<const traversability::NavigationMap> map,
    const GlobalPlannerOptions& options = {}) {
  auto planner = MakeGlobalPlanner(std::move(map), core::RobotModel(), options);
  EXPECT_TRUE(planner.ok()) << planner.status();
  return *std::move(planner);
}

core::LevelPose At(double x, double y, double yaw_rad = 0, int level = 0) {
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
void ExpectClear(const traversability::NavigationMap& map,
                 const PlanResult& result) {
  const auto ground = std::make_shared<const GroundIndex>(
      std::make_shared<const traversability::NavigationMap>(map));
  const ConfigurationSpace space(ground, Footprint::Of(core::RobotModel(), 0.0),
                                 {});
  const geometry::Rigid2 grid_from_map = map.grid(0).map_from_grid.Inverse();
  for (size_t i = 1; i < result.path.size(); ++i) {
    const geometry::Rigid2 from =
        grid_from_map * result.path[i - 1].map_from_base;
    const geometry::Rigid2 to = grid_from_map * result.path[i].map_from_base;
    for (int k = 0; k <= 20; ++k) {
      const double t = k / 20.0;
      const geometry::Vec2 at =
          from.translation + t * (to.translation - from.translation);
      const std::optional<Spot> spot =
          space.Follow({from.translation, result.path[i - 1].place.level}, at);
      ASSERT_TRUE(spot.has_value() && space.Fits(*spot, from.yaw_rad))
          << "pose " << i << " of " << result.path.size() << " at (" << at.x
          << ", " << at.y << ")";
    }
    EXPECT_TRUE(space.CanTurn({to.translation, result.path[i].place.level},
                              from.yaw_rad, to.yaw_rad));
  }
}

std::shared_ptr<const traversability::NavigationMap> TwoRooms(int width_dm) {
  return DrawnMap(TwoRoomsRows(width_dm));
}

TEST(GlobalPlannerTest, StraightWayInAnEmptyRoomIsStraight) {
  const auto map = DrawnMap(RoomRows(60, 40));
  const PlanResult result =
      PlanOf(*Planner(map), {.start = At(1, 2), .goal = At(5, 2, kPi / 2)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  EXPECT_NEAR(result.length_m, 4, 0.001);
  EXPECT_EQ(result.path.front().map_from_base, At(1, 2).map_from_base);
  // The surface is half a voxel above the layer.
  EXPECT_NEAR(result.path.front().place.height_m, 0.025, 1e-6);
  EXPECT_NEAR(result.path.back().map_from_base.yaw_rad, kPi / 2, 1e-9);
  ExpectClear(*map, result);
}

TEST(GlobalPlannerTest, WaysAreAsShortAsTheFootprintLets) {
  // Round the end of a wall: two tangents, two arcs of half a width and a
  // margin about its corners, and a line between them.
  std::vector<std::string> rows = RoomRows(80, 60);
  Fill(rows, 40, 42, 30, 59, '#');
  const auto map = DrawnMap(rows);
  constexpr double kRadius_m = 0.31 + 0.03;
  const auto half_m = [](double x, double y) {
    const double reach_m = std::hypot(x, y);
    return std::sqrt(reach_m * reach_m - kRadius_m * kRadius_m) +
           kRadius_m * (std::atan2(y, x) + std::asin(kRadius_m / reach_m));
  };
  const double shortest_m = half_m(3, 1.5) + 0.2 + half_m(2.8, 1.5);
  const PlanResult result =
      PlanOf(*Planner(map), {.start = At(1, 4.5), .goal = At(7, 4.5)}, 20000);
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  ExpectClear(*map, result);
  EXPECT_LT(result.length_m, 1.01 * shortest_m);
  EXPECT_GT(result.length_m, 0.999 * shortest_m);
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
      ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
      ExpectClear(*map, result);
      EXPECT_LT(result.length_m, 9.0);
    }
  }
}

TEST(GlobalPlannerTest, PassesDoorsThatLeaveLessRoomThanTheMargin) {
  // 0.65 m: 3 cm more than the robot, 3 cm less than it and its margins.
  std::vector<std::string> rows = RoomRows(160, 100);
  Fill(rows, 80, 84, 1, 99, '#');
  Fill(rows, 80, 84, 40, 53, '.');
  const auto map = DrawnMap(rows, 1);
  const PlanResult result = PlanOf(
      *Planner(map), {.start = At(1, 4, kPi / 2), .goal = At(7, 4, -kPi / 2)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  ExpectClear(*map, result);
  EXPECT_LT(result.length_m, 9.0);
}

TEST(GlobalPlannerTest, SaysThatThereIsNoWayThroughATooNarrowDoor) {
  const PlanRequest request = {.start = At(1, 4), .goal = At(7, 4)};
  // No disc of the robot's length gets through.
  const PlanResult none = PlanOf(*Planner(TwoRooms(5)), request);
  EXPECT_EQ(none.failure, core::NavigationCause::kNoPath);
  EXPECT_THAT(none.why, testing::HasSubstr("no free ground"));
  EXPECT_TRUE(none.path.empty());
  EXPECT_EQ(none.iterations, 0);
  // One does, but the robot is 2 cm wider.
  const PlanResult narrow = PlanOf(*Planner(TwoRooms(6)), request);
  EXPECT_EQ(narrow.failure, core::NavigationCause::kNoPath);
  EXPECT_THAT(narrow.why, testing::HasSubstr("too narrow"));
  EXPECT_TRUE(narrow.path.empty());
}

TEST(GlobalPlannerTest, NamesGoalsThatAreOutsideOrHaveNoRoom) {
  std::vector<std::string> rows = RoomRows(60, 60);
  Fill(rows, 30, 55, 30, 55, '#');
  const auto planner = Planner(DrawnMap(rows));
  const auto failure = [&](const core::LevelPose& start,
                           const core::LevelPose& goal) {
    const PlanResult result = PlanOf(*planner, {.start = start, .goal = goal});
    EXPECT_EQ(result.why.empty(),
              result.failure == core::NavigationCause::kNone);
    return result.failure;
  };
  EXPECT_EQ(failure(At(1, 1), At(9, 1)), core::NavigationCause::kGoalOutside);
  EXPECT_EQ(failure(At(1, 1), At(1, 1, 0, 3)),
            core::NavigationCause::kGoalOutside);
  EXPECT_EQ(failure(At(1, 1), At(1, 1, 0, -1)),
            core::NavigationCause::kGoalOutside);
  EXPECT_EQ(failure(At(1, 1), At(1e300, 1)),
            core::NavigationCause::kGoalOutside);
  EXPECT_EQ(failure(At(1, 1), At(4.2, 4.2)),
            core::NavigationCause::kGoalBlocked);
  EXPECT_EQ(failure(At(4.2, 4.2), At(1, 1)),
            core::NavigationCause::kStartBlocked);
  EXPECT_EQ(failure(At(-3, 0), At(1, 1)), core::NavigationCause::kStartBlocked);
}

TEST(GlobalPlannerTest, PosesThatAreNotFiniteAreRefused) {
  const auto planner = Planner(DrawnMap(RoomRows(40, 40)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const PlanRequest& request : std::vector<PlanRequest>{
           {.start = At(nan, 1), .goal = At(1, 1)},
           {.start = At(1, 1), .goal = At(1, 1, nan)},
           {.start = At(1, 1),
           .goal = At(2, 2),
           .blockages = {{.center = {1, nan}, .radius_m = 1, .level = 0}}}}) {
    EXPECT_EQ(planner->Plan(request, {}, {}).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(GlobalPlannerTest, GoalInATableIsMovedToTheNearestRoom) {
  std::vector<std::string> rows = RoomRows(60, 40);
  Fill(rows, 40, 46, 17, 23, '#');
  const auto map = DrawnMap(rows);
  // 0.25 m inside of the table's left side: the robot's front must be out.
  const PlanResult result =
      PlanOf(*Planner(map), {.start = At(1, 2), .goal = At(4.1, 2)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  // To 0.33 m before it: 0.43 m, and at most a cell more.
  EXPECT_GE(result.moved_goal_m, 0.43 - 1e-9);
  EXPECT_LE(result.moved_goal_m, 0.43 + 0.075);
  EXPECT_EQ(result.path.back().map_from_base.yaw_rad, 0);
  ExpectClear(*map, result);
}

TEST(GlobalPlannerTest, RobotThatStandsTooNearToAWallGetsOut) {
  const auto map = DrawnMap(RoomRows(60, 40));
  // 5 cm of the robot's side are where the map says that the wall is.
  const PlanResult result =
      PlanOf(*Planner(map), {.start = At(2, 0.36), .goal = At(5, 3, kPi / 2)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  EXPECT_GT(result.moved_start_m, 0.07);
  EXPECT_LT(result.moved_start_m, 0.15);
  ExpectClear(*map, result);
}

TEST(GlobalPlannerTest, NoseInANicheNeedsAStraightWayIn) {
  // A niche of 0.8 m x 1 m in the right wall: no room to turn.
  std::vector<std::string> rows = RoomRows(60, 40);
  Fill(rows, 45, 59, 1, 39, '#');
  Fill(rows, 45, 55, 16, 24, '.');
  const auto map = DrawnMap(rows);
  const auto planner = Planner(map);
  const PlanResult in =
      PlanOf(*planner, {.start = At(1, 1, kPi), .goal = At(5.1, 2, 0)});
  ASSERT_EQ(in.failure, core::NavigationCause::kNone) << in.why;
  ExpectClear(*map, in);
  EXPECT_NEAR(in.path[in.path.size() - 2].map_from_base.yaw_rad, 0, 0.2);
  const PlanResult out =
      PlanOf(*planner, {.start = At(5.1, 2, kPi), .goal = At(1, 1, 0)});
  ASSERT_EQ(out.failure, core::NavigationCause::kNone) << out.why;
  ExpectClear(*map, out);
}

TEST(GlobalPlannerTest, RobotWithItsNoseToAWallIsPlannedFromBehind) {
  const auto map = DrawnMap(RoomRows(60, 40));
  // Its front is 1 cm further from the wall than the margin: it cannot turn.
  const PlanResult result = PlanOf(
      *Planner(map), {.start = At(5.56, 2, 0), .goal = At(1, 1, kPi / 2)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  EXPECT_NEAR(result.moved_start_m, 0.2, 0.11);
  EXPECT_NEAR(result.path.front().map_from_base.translation.y, 2, 1e-9);
  ExpectClear(*map, result);
}

TEST(GlobalPlannerTest, GoesAroundBlockages) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const Blockage blockage = {.center = {4, 2.5}, .radius_m = 0.6, .level = 0};
  const PlanResult result = PlanOf(
      *Planner(map),
      {.start = At(1, 2.5), .goal = At(7, 2.5), .blockages = {blockage}});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  for (const core::LevelPose& pose : result.path) {
    const double away_m =
        geometry::Norm(pose.map_from_base.translation - blockage.center);
    EXPECT_GE(away_m, 0.6 + core::RobotModel().front_m);
  }
  EXPECT_LT(result.length_m, 6.7);
}

TEST(GlobalPlannerTest, ABlockedDoorIsNoWay) {
  const PlanResult result = PlanOf(
      *Planner(TwoRooms(9)),
      {.start = At(1, 4),
       .goal = At(7, 4),
       .blockages = {{.center = {4.1, 2.4}, .radius_m = 0.3, .level = 0}}});
  EXPECT_EQ(result.failure, core::NavigationCause::kNoPath);
}

TEST(GlobalPlannerTest, UnknownGroundIsNotDrivenOnUnlessAllowed) {
  std::vector<std::string> rows = RoomRows(80, 50);
  Fill(rows, 38, 44, 1, 49, '?');
  const PlanRequest request = {.start = At(1, 2), .goal = At(7, 2)};
  EXPECT_EQ(PlanOf(*Planner(DrawnMap(rows)), request).failure,
            core::NavigationCause::kNoPath);
  EXPECT_EQ(
      PlanOf(*Planner(DrawnMap(
                 rows, 2, {},
                 {.reach_m = 3, .max_rise_m = 0.3, .allow_unknown = true})),
             request)
          .failure,
      core::NavigationCause::kNone);
}

TEST(GlobalPlannerTest, KeepsAwayFromWallsWhereThereIsRoom) {
  // The straight line passes the block's corners at 0.4 m.
  std::vector<std::string> rows = RoomRows(80, 50);
  Fill(rows, 30, 50, 1, 20, '#');
  const auto map = DrawnMap(rows);
  const PlanResult result =
      PlanOf(*Planner(map), {.start = At(1.5, 2.4), .goal = At(6.5, 2.4)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  double nearest_m = 10;
  for (const core::LevelPose& pose : result.path) {
    nearest_m = std::min(nearest_m,
                         map->Clearance_m(0, pose.map_from_base.translation));
  }
  EXPECT_GT(nearest_m, 0.5);
  EXPECT_LT(result.length_m, 5.1);
}

TEST(GlobalPlannerTest, SameSeedSamePathOtherwiseTurnedMap) {
  const auto rows = RoomRows(80, 50);
  const PlanRequest request = {.start = At(1, 1),
                               .goal = At(7, 4, 1),
                               .blockages = {{{4, 2.5}, 0.7, 0}},
                               .seed = 5};
  const auto planner = Planner(DrawnMap(rows));
  const PlanResult once = PlanOf(*planner, request);
  const PlanResult again = PlanOf(*planner, request);
  EXPECT_EQ(once.path, again.path);
  EXPECT_EQ(once.iterations, again.iterations);
  // The same map and request in a turned frame.
  const geometry::Rigid2 turned = {.translation = {10, -3}, .yaw_rad = 0.7};
  PlanRequest there = request;
  there.start.map_from_base = turned * request.start.map_from_base;
  there.goal.map_from_base = turned * request.goal.map_from_base;
  there.blockages[0].center = turned * request.blockages[0].center;
  const PlanResult other = PlanOf(*Planner(DrawnMap(rows, 2, turned)), there);
  ASSERT_EQ(other.failure, core::NavigationCause::kNone) << other.why;
  EXPECT_NEAR(other.length_m, once.length_m, 0.1);
  EXPECT_NEAR(geometry::Norm(other.path.back().map_from_base.translation -
                             there.goal.map_from_base.translation),
              0, 1e-9);
}

// Two floors of 6 x 4 m, the upper one to the right and 0.1 m higher, joined in
// a strip 1.4 m wide.
std::shared_ptr<const traversability::NavigationMap> TwoLevels() {
  std::vector<std::string> lower = RoomRows(120, 40);
  std::vector<std::string> upper = RoomRows(120, 40);
  Fill(lower, 60, 120, 0, 40, '?');
  Fill(upper, 0, 60, 0, 40, '?');
  Fill(lower, 58, 60, 1, 13, '#');
  Fill(lower, 58, 60, 27, 39, '#');
  Fill(upper, 60, 62, 1, 13, '#');
  Fill(upper, 60, 62, 27, 39, '#');
  traversability::TraversableMap map;
  map.levels = {DrawnLevel(lower, 2, 0.0F), DrawnLevel(upper, 2, 0.1F)};
  map.joins = {{.lower_level = 0, .upper_level = 1, .cells = {{119, 40}}}};
  return std::make_shared<const traversability::NavigationMap>(
      *traversability::NavigationMap::Make(std::move(map)));
}

TEST(GlobalPlannerTest, GoesOverAJoinToAnotherLevelAndBack) {
  const auto map = TwoLevels();
  const auto planner = Planner(map);
  const PlanResult up =
      PlanOf(*planner, {.start = At(1, 1), .goal = At(11, 3, 0, 1)});
  ASSERT_EQ(up.failure, core::NavigationCause::kNone) << up.why;
  ExpectClear(*map, up);
  for (const core::LevelPose& pose : up.path) {
    const bool is_lower = pose.map_from_base.translation.x < 6;
    EXPECT_EQ(pose.place.level, is_lower ? 0 : 1);
    EXPECT_NEAR(pose.place.height_m, is_lower ? 0.025 : 0.125, 1e-6);
  }
  const PlanResult down =
      PlanOf(*planner, {.start = At(11, 3, 0, 1), .goal = At(1, 1, 0, 0)});
  ASSERT_EQ(down.failure, core::NavigationCause::kNone) << down.why;
  EXPECT_EQ(down.path.back().place.level, 0);
}

TEST(GlobalPlannerTest, StopsWhenItIsAskedTo) {
  std::stop_source source;
  source.request_stop();
  const auto result =
      Planner(DrawnMap(RoomRows(60, 40)))
          ->Plan({.start = At(1, 1), .goal = At(5, 3)}, {}, source.get_token());
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled);
}

TEST(GlobalPlannerTest, PlannersThatThereAreNotAreNamed) {
  const auto map = DrawnMap(RoomRows(40, 40));
  GlobalPlannerOptions options;
  options.planner = "rtt-connect";
  const auto made = MakeGlobalPlanner(map, core::RobotModel(), options);
  EXPECT_EQ(made.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(made.status().message()),
              testing::AllOf(testing::HasSubstr("rtt-connect"),
                             testing::HasSubstr("bit-star")));
  options = {};
  options.margin_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(MakeGlobalPlanner(map, core::RobotModel(), options).ok());
}

class OmplPlannersTest : public testing::TestWithParam<const char*> {};

TEST_P(OmplPlannersTest, FindWaysThatCanBeDrivenOverBothLevels) {
  GlobalPlannerOptions options;
  options.planner = GetParam();
  const auto map = TwoLevels();
  const auto planner = Planner(map, options);
  const PlanRequest request = {.start = At(1, 1, 1), .goal = At(11, 3, 2, 1)};
  const PlanResult result = PlanOf(*planner, request, 2000);
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  ExpectClear(*map, result);
  EXPECT_EQ(result.path.back().place.level, 1);
  // The straight line is 10.2 m.
  EXPECT_LT(result.length_m, 11.5);
  EXPECT_FALSE(result.tree_edges.empty());
  EXPECT_EQ(PlanOf(*planner, request, 2000).path, result.path);
}

TEST_P(OmplPlannersTest, PassDoors) {
  GlobalPlannerOptions options;
  options.planner = GetParam();
  const auto map = TwoRooms(12);
  const PlanResult result =
      PlanOf(*Planner(map, options),
             {.start = At(1, 4, kPi / 2), .goal = At(7, 4)}, 2500);
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  ExpectClear(*map, result);
}

INSTANTIATE_TEST_SUITE_P(All, OmplPlannersTest,
                         testing::Values("rrt-connect", "rrt-star", "bit-star",
                                         "informed-rrt-star",
                                         "ompl-variable-rrt"));

}  // namespace
}  // namespace treeline::planning

#include "nav_agent/planning/zone_planner.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline::planning {
namespace {

using testing::HasSubstr;
using zones::Zone;
using zones::ZoneKind;
using zones::ZoneMap;

constexpr double kPi = std::numbers::pi;
constexpr double kFull_mps = 0.6;

core::LevelPose At(double x, double y, double yaw_rad = 0, int level = 0) {
  return {.map_from_base = {.translation = {x, y}, .yaw_rad = yaw_rad},
          .place = {.level = level, .height_m = 0}};
}

Zone Box(ZoneKind kind, double x0, double y0, double x1, double y1,
         double direction_rad = 0) {
  return {.name = "box",
          .kind = kind,
          .level = 0,
          .corners_in_map = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}},
          .max_mps = 0.2,
          .direction_rad = direction_rad};
}

std::shared_ptr<const ZoneMap> ZonesOf(const traversability::NavigationMap& map,
                                       const std::vector<Zone>& zones) {
  const auto made = ZoneMap::Make(map.traversable(), zones, {}, kFull_mps);
  EXPECT_TRUE(made.ok()) << made.status();
  return made.value_or(nullptr);
}

class ZonePlannerTest : public testing::TestWithParam<std::string> {
 protected:
  PlanResult Plan(
      const std::shared_ptr<const traversability::NavigationMap>& map,
      const core::LevelPose& start, const core::LevelPose& goal,
      const std::vector<Zone>& zones) {
    zones_ = ZonesOf(*map, zones);
    const auto planner =
        MakeGlobalPlanner(map, core::RobotModel(), {.planner = GetParam()});
    EXPECT_TRUE(planner.ok()) << planner.status();
    const auto result = (*planner)->Plan(
        {.start = start, .goal = goal, .seed = 1, .zones = zones_},
        {.max_iterations = 3000}, {});
    EXPECT_TRUE(result.ok()) << result.status();
    return result.value_or(PlanResult());
  }
  // Whether some of the footprint is in what is kept out of.
  bool Touches(const core::LevelPose& pose) const {
    const core::RobotModel robot;
    for (double x = -robot.rear_m; x <= robot.front_m; x += 0.02) {
      for (double y = -robot.half_width_m; y <= robot.half_width_m; y += 0.02) {
        if (zones_->IsKeptOut(pose.place.level,
                              pose.map_from_base * geometry::Vec2{x, y})) {
          return true;
        }
      }
    }
    return false;
  }

  std::shared_ptr<const ZoneMap> zones_;
};

INSTANTIATE_TEST_SUITE_P(AllPlanners, ZonePlannerTest,
                         testing::Values("variable-rrt", "rrt-connect",
                                         "ompl-variable-rrt"),
                         [](const auto& tested) {
                           std::string name = tested.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST_P(ZonePlannerTest, GoesAroundWhatIsKeptOutOf) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const PlanResult result = Plan(map, At(1, 2.5), At(7, 2.5),
                                 {Box(ZoneKind::kKeepOut, 3, 0, 5, 3.5)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  EXPECT_GT(result.length_m, 6.2);
  for (const core::LevelPose& pose : result.path) EXPECT_FALSE(Touches(pose));
}

TEST_P(ZonePlannerTest, AGoalInAZoneIsRefusedByName) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const PlanResult result =
      Plan(map, At(1, 2.5), At(4, 2.5), {Box(ZoneKind::kKeepOut, 3, 1, 5, 4)});
  EXPECT_EQ(result.failure, core::NavigationCause::kZone);
  EXPECT_THAT(result.why, HasSubstr("keep-out zone 'box'"));
}

TEST_P(ZonePlannerTest, AGoalBesideTheMapIsThatFromWithinAZone) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const std::vector<Zone> zones = {Box(ZoneKind::kKeepOut, 3, 1, 5, 4)};
  EXPECT_EQ(Plan(map, At(4, 2.5), At(40, 2.5), zones).failure,
            core::NavigationCause::kGoalOutside);
  EXPECT_EQ(Plan(map, At(4, 2.5), At(7, 2.5, 0, 7), zones).failure,
            core::NavigationCause::kGoalOutside);
}

TEST_P(ZonePlannerTest, ZonesThatCutTheGoalOffAreBlamed) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const PlanResult result =
      Plan(map, At(1, 2.5), At(7, 2.5), {Box(ZoneKind::kKeepOut, 3, -1, 5, 6)});
  EXPECT_EQ(result.failure, core::NavigationCause::kZone);
  EXPECT_THAT(result.why, HasSubstr("without them there is one"));
  EXPECT_TRUE(result.path.empty());
}

TEST_P(ZonePlannerTest, DrivesOutOfAZoneFirstAndNotThroughIt) {
  const auto map = DrawnMap(RoomRows(120, 50));
  // It stands near the left end of a long zone; the goal is beyond its right
  // end. Straight through would be 9 m.
  const PlanResult result = Plan(map, At(2.4, 2.5, kPi / 2), At(11, 2.5),
                                 {Box(ZoneKind::kKeepOut, 2, 1.8, 10, 3.2)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  EXPECT_EQ(result.path.front().map_from_base.translation.x, 2.4);
  size_t inside = 0;
  bool is_out = false;
  for (const core::LevelPose& pose : result.path) {
    const bool touches = Touches(pose);
    inside += touches ? 1 : 0;
    EXPECT_FALSE(is_out && touches) << "it drives into the zone again";
    is_out = is_out || !touches;
  }
  // Poses are at most 0.1 m apart: out within a metre and a half.
  EXPECT_LT(inside, 20u);
  EXPECT_TRUE(is_out);
}

TEST_P(ZonePlannerTest, StandsWhereNoWayOutLeadsToTheGoal) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const PlanResult result = Plan(map, At(4, 2.5), At(7, 2.5),
                                 {Box(ZoneKind::kKeepOut, 3, -1, 5, 6), [] {
                                    Zone around =
                                        Box(ZoneKind::kKeepOut, 5, -1, 6, 6);
                                    around.name = "beyond";
                                    return around;
                                  }()});
  // The two are one piece, and it leads out of it on the goal's side.
  EXPECT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
}

TEST_P(ZonePlannerTest, ZonesOfAnotherLevelDoNotCount) {
  traversability::TraversableMap levels;
  levels.levels.push_back(DrawnLevel(RoomRows(80, 50), 2, 0.0F));
  levels.levels.push_back(DrawnLevel(RoomRows(80, 50), 2, 3.0F));
  const auto map = std::make_shared<const traversability::NavigationMap>(
      *traversability::NavigationMap::Make(std::move(levels)));
  Zone above = Box(ZoneKind::kKeepOut, 3, -1, 5, 6);
  above.level = 1;
  const PlanResult below = Plan(map, At(1, 2.5), At(7, 2.5), {above});
  ASSERT_EQ(below.failure, core::NavigationCause::kNone) << below.why;
  EXPECT_NEAR(below.length_m, 6, 0.01);
  core::LevelPose start = At(1, 2.5, 0, 1);
  core::LevelPose goal = At(7, 2.5, 0, 1);
  start.place.height_m = goal.place.height_m = 3.025;
  EXPECT_EQ(Plan(map, start, goal, {above}).failure,
            core::NavigationCause::kZone);
}

TEST_P(ZonePlannerTest, ACorridorIsDrivenOneWayAndNotBack) {
  const auto map = DrawnMap(RoomRows(80, 30));
  const Zone lane = Box(ZoneKind::kOneWay, 3, -1, 5, 4);
  const PlanResult with = Plan(map, At(1, 1.5), At(7, 1.5), {lane});
  ASSERT_EQ(with.failure, core::NavigationCause::kNone) << with.why;
  EXPECT_NEAR(with.length_m, 6, 0.1);
  const PlanResult against =
      Plan(map, At(7, 1.5, kPi), At(1, 1.5, kPi), {lane});
  EXPECT_EQ(against.failure, core::NavigationCause::kZone);
  EXPECT_THAT(against.why, HasSubstr("zones leave no way"));
}

TEST_P(ZonePlannerTest, GoesRoundAOneWayZoneThatIsAgainstIt) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const PlanResult result = Plan(map, At(7, 1.5, kPi), At(1, 1.5, kPi),
                                 {Box(ZoneKind::kOneWay, 3, -1, 5, 3)});
  ASSERT_EQ(result.failure, core::NavigationCause::kNone) << result.why;
  for (const core::LevelPose& pose : result.path) {
    const geometry::Vec2 at = pose.map_from_base.translation;
    if (at.x < 3 || at.x > 5) continue;
    EXPECT_GT(at.y, 2.95) << at.x;
  }
}

// Two lanes side by side, one for each direction: as on a road.
TEST_P(ZonePlannerTest, KeepsToTheLaneOfItsDirection) {
  const auto map = DrawnMap(RoomRows(80, 40));
  Zone right = Box(ZoneKind::kOneWay, 2, -1, 6, 2, 0);
  Zone left = Box(ZoneKind::kOneWay, 2, 2.06, 6, 5, kPi);
  left.name = "left";
  const PlanResult there = Plan(map, At(1, 2), At(7, 2), {right, left});
  const PlanResult back =
      Plan(map, At(7, 2, kPi), At(1, 2, kPi), {right, left});
  ASSERT_EQ(there.failure, core::NavigationCause::kNone) << there.why;
  ASSERT_EQ(back.failure, core::NavigationCause::kNone) << back.why;
  for (const PlanResult* result : {&there, &back}) {
    for (const core::LevelPose& pose : result->path) {
      const geometry::Vec2 at = pose.map_from_base.translation;
      if (at.x < 2.2 || at.x > 5.8) continue;
      EXPECT_EQ(at.y < 2.05, result == &there) << at.x << " " << at.y;
    }
  }
}

// A zone that is drawn while it plans is respected by the next plan; the ground
// of the one before is not used for it.
TEST(ZonePlannerCacheTest, NewZonesAreNewGround) {
  const auto map = DrawnMap(RoomRows(80, 50));
  const auto planner = *MakeGlobalPlanner(map, core::RobotModel(), {});
  const auto length = [&](const std::shared_ptr<const ZoneMap>& zones) {
    const auto result = planner->Plan(
        {.start = At(1, 2.5), .goal = At(7, 2.5), .seed = 1, .zones = zones},
        {.max_iterations = 3000}, {});
    EXPECT_TRUE(result.ok() && result->failure == core::NavigationCause::kNone);
    return result->length_m;
  };
  const auto zones = ZonesOf(*map, {Box(ZoneKind::kKeepOut, 3, 0, 5, 3.5)});
  EXPECT_NEAR(length(nullptr), 6, 0.01);
  EXPECT_GT(length(zones), 6.2);
  EXPECT_NEAR(length(ZonesOf(*map, {})), 6, 0.01);
  EXPECT_GT(length(zones), 6.2);
}

}  // namespace
}  // namespace treeline::planning

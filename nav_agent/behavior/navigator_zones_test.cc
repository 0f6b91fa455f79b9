// A navigator whose zones change.
#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/behavior/testing_navigator.h"

namespace treeline::behavior {
namespace {

using ::testing::HasSubstr;

class NavigatorZonesTest : public NavigatorFixture {
 protected:
  static std::shared_ptr<const zones::ZoneMap> Box(double x0, double y0,
                                                   double x1, double y1) {
    const zones::Zone zone = {
        .name = "stairs",
        .kind = zones::ZoneKind::kKeepOut,
        .level = 0,
        .corners_in_map = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}};
    const auto made =
        zones::ZoneMap::Make(OpenMap()->traversable(), {&zone, 1}, {}, 0.6);
    EXPECT_TRUE(made.ok()) << made.status();
    return made.value_or(nullptr);
  }
};

TEST_F(NavigatorZonesTest, PlansAndControlAreToldBeforeTheFirstGoal) {
  MakePlaced();
  const auto zones = Box(4, 4, 5, 5);
  ASSERT_TRUE(navigator->SetZones(zones).ok());
  EXPECT_EQ(controller->zones, zones);
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  ASSERT_FALSE(planner->requests.empty());
  EXPECT_EQ(planner->requests.back().zones, zones);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
}

TEST_F(NavigatorZonesTest, AGoalInAZoneIsRefusedByName) {
  MakePlaced();
  ASSERT_TRUE(navigator->SetZones(Box(4, 4, 5, 5)).ok());
  const absl::Status status =
      navigator->SetGoal({.poses = {PoseAtPoint(7, 2), PoseAtPoint(4.5, 4.5)}})
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("lies in the keep-out zone 'stairs'"));
  EXPECT_FALSE(navigator->goal().has_value());
  // On the level above nothing is kept out of.
  EXPECT_TRUE(
      navigator->SetGoal({.poses = {PoseAtPoint(4.5, 4.5, 0, 1)}}).ok());
}

TEST_F(NavigatorZonesTest, ZonesThatChangeOnTheWayHaveItPlanAnew) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  ASSERT_EQ(mode(), NavigatorMode::kDriving);
  const size_t plans = planner->requests.size();
  planner->holds = true;
  const auto zones = Box(4, 1, 5, 3);
  ASSERT_TRUE(navigator->SetZones(zones).ok());
  Run(kStep_s);
  // It stands until there is a new way.
  EXPECT_EQ(mode(), NavigatorMode::kPlanning);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_TRUE(controller->path.empty());
  ASSERT_EQ(planner->requests.size(), plans + 1);
  EXPECT_EQ(planner->requests.back().zones, zones);
  planner->holds = false;
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(Count("zones", "plans anew"), 1);
}

TEST_F(NavigatorZonesTest, NoZonesInsteadOfNoneDisturbNobody) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  const auto none = zones::ZoneMap::Make(OpenMap()->traversable(), {}, {}, 0.6);
  ASSERT_TRUE(navigator->SetZones(*none).ok());
  Run(kStep_s);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(Count("zones", ""), 0);
}

TEST_F(NavigatorZonesTest, ZonesThatLeaveNoWayEndTheGoalAtOnce) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  planner->answers.emplace_back(FakePlannerWorker::Failure(
      core::NavigationCause::kZone, "zones leave no way"));
  ASSERT_TRUE(navigator->SetZones(Box(4, 1, 5, 3)).ok());
  Run(0.1);
  EXPECT_EQ(Goal().state, GoalState::kFailed);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kZone);
  EXPECT_THAT(Goal().why, HasSubstr("zones leave no way"));
  EXPECT_EQ(Goal().recoveries, 0);
}

TEST_F(NavigatorZonesTest, NobodyIsSteeredToADockThatIsKeptOut) {
  MakePlaced();
  const SteeringCommand steering = {
      .wanted = {.forward_mps = 0.1, .yaw_rate_radps = 0},
      .docked = PoseAtPoint(4.5, 2),
      .what = "drives in"};
  ASSERT_TRUE(navigator->Steer(steering).ok());
  ASSERT_TRUE(navigator->SetZones(Box(4, 1, 5, 3)).ok());
  EXPECT_EQ(navigator->Steer(steering).code(),
            absl::StatusCode::kFailedPrecondition);
  // It may still leave it.
  SteeringCommand out = steering;
  out.is_leaving = true;
  EXPECT_TRUE(navigator->Steer(out).ok());
  // Beside it stands another.
  SteeringCommand other = steering;
  other.docked = PoseAtPoint(7, 2);
  EXPECT_TRUE(navigator->Steer(other).ok());
}

}  // namespace
}  // namespace treeline::behavior

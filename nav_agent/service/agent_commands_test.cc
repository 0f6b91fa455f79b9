#include "nav_agent/service/agent_commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "common/base/testing_folder.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(AgentCommands, AGoalGetsTheGroundOfItsLevel) {
  SteppingAgent agent;
  const auto id = agent.commands.SetGoal(
      {{.x_m = 0.5, .y_m = 0.5, .yaw_rad = 7, .level = 1}});
  ASSERT_TRUE(id.ok()) << id.status();
  const std::vector<core::LevelPose> poses = agent.commands.PosesOf(*id);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].place, (core::LevelPlace{1, 1.0}));
  EXPECT_NEAR(poses[0].map_from_base.yaw_rad, 7 - 2 * std::numbers::pi, 1e-12);
  EXPECT_TRUE(agent.commands.PosesOf(*id + 1).empty());
}

TEST(AgentCommands, RefusesGoalsThatAreNone) {
  SteppingAgent agent;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(agent.commands.SetGoal({}).status().message(),
              HasSubstr("a pose at least"));
  EXPECT_THAT(agent.commands.SetGoal({{.x_m = nan}}).status().message(),
              HasSubstr("poses[0] has a NaN"));
  EXPECT_THAT(agent.commands.SetGoal({{}, {.level = 2}}).status().message(),
              HasSubstr("poses[1] is on level 2; the map has 0..1"));
  EXPECT_THAT(agent.commands.SetGoal({{.level = -1}}).status().message(),
              HasSubstr("level -1"));
  EXPECT_THAT(agent.commands.SetGoal({{.x_m = 1e6}}).status().message(),
              HasSubstr("no map reaches that far"));
  EXPECT_THAT(agent.commands.SetGoal(std::vector<RequestedPose>(101))
                  .status()
                  .message(),
              HasSubstr("101 poses"));
  for (const auto& bad : {agent.commands.SetGoal({{.level = 2}})}) {
    EXPECT_TRUE(absl::IsInvalidArgument(bad.status()));
  }
}

TEST(AgentCommands, ZonesReachTheRobotOrNothingChanges) {
  SteppingAgent agent;
  zones::Zone zone = {
      .name = "stairs",
      .kind = zones::ZoneKind::kKeepOut,
      .level = 0,
      .corners_in_map = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}}};
  const auto put = agent.commands.PutZones({zone});
  ASSERT_TRUE(put.ok()) << put.status();
  EXPECT_EQ(agent.commands.zones().revision(), 2U);
  // Without a state folder.
  EXPECT_THAT(agent.commands.zones().keeping().message(),
              HasSubstr("--state-dir"));
  zone.corners_in_map[1].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(
      absl::IsInvalidArgument(agent.commands.PutZones({zone}).status()));
  EXPECT_TRUE(absl::IsNotFound(agent.commands.RemoveZones({"x"}).status()));
  EXPECT_EQ(agent.commands.zones().revision(), 2U);
  agent.Close();
  EXPECT_EQ(agent.navigator.zones, put->map);
  // Nobody steps any more.
  EXPECT_TRUE(
      absl::IsUnavailable(agent.commands.RemoveZones({"stairs"}).status()));
  EXPECT_EQ(agent.commands.zones().contents().zones.size(), 1U);
}

TEST(AgentCommands, APoseComesWithItsDoubt) {
  SteppingAgent agent;
  ASSERT_TRUE(agent.commands.SetPose({.x_m = 1}, 0.5, 0.1).ok());
  agent.Close();
  ASSERT_TRUE(agent.navigator.snapshot.pose.has_value());
  EXPECT_DOUBLE_EQ(agent.navigator.snapshot.pose->covariance[0], 0.25);
  EXPECT_DOUBLE_EQ(agent.navigator.snapshot.pose->covariance[8], 0.1 * 0.1);
}

TEST(AgentCommands, RefusesDoubtThatIsNone) {
  SteppingAgent agent;
  EXPECT_FALSE(agent.commands.SetPose({}, 0, 0.1).ok());
  EXPECT_FALSE(agent.commands.SetPose({}, 0.1, -1).ok());
  EXPECT_FALSE(agent.commands.SetPose({}, 101, 1).ok());
}

TEST(AgentCommands, ARealRobotCannotBeKidnapped) {
  SteppingAgent agent(/*is_simulated=*/false);
  EXPECT_TRUE(absl::IsUnimplemented(agent.commands.Kidnap({}).status()));
  EXPECT_TRUE(absl::IsUnimplemented(agent.commands.KidnapAnywhere().status()));
  EXPECT_TRUE(
      absl::IsUnimplemented(agent.commands.AddObstacle({}, 0.5).status()));
  EXPECT_TRUE(absl::IsUnimplemented(agent.commands.RemoveObstacle("a")));
  EXPECT_TRUE(absl::IsUnimplemented(agent.commands.InjectFault({})));
}

TEST(AgentCommands, ASimulatedOneCan) {
  SteppingAgent agent;
  EXPECT_TRUE(agent.commands.Kidnap({.x_m = 1, .level = 1}).ok());
  EXPECT_TRUE(agent.commands.KidnapTo("kitchen").ok());
  EXPECT_TRUE(absl::IsNotFound(agent.commands.KidnapTo("moon").status()));
  EXPECT_TRUE(agent.commands.KidnapAnywhere().ok());
  EXPECT_FALSE(agent.commands.AddObstacle({}, 9).ok());
  EXPECT_EQ(agent.commands.AddObstacle({}, 0.4).value(), "box-1");
  EXPECT_TRUE(agent.commands.RemoveObstacle("box-1").ok());
  agent.Close();
  EXPECT_THAT(
      agent.simulation.calls,
      ElementsAre("kidnap 1 0 on 1 at 1", "kidnap to kitchen",
                  "kidnap anywhere", "obstacle of 0.4 on 0", "remove box-1"));
}

// ---- routes ----

routes::Route ThereAndBack() {
  return {
      .name = "patrol",
      .waypoints = {{.position_in_map = {1, 0}}, {.position_in_map = {0, 0}}}};
}

// The route, once the stepping thread has it so.
std::optional<routes::RouteStatus> RouteThatIs(const AgentHub& hub,
                                               routes::RouteState wanted) {
  uint64_t seen = 0;
  for (;;) {
    const auto state = hub.WaitForNewer(seen, absl::Now() + absl::Seconds(60));
    if (state == nullptr) return std::nullopt;
    seen = state->number;
    if (state->route.has_value() && state->route->state == wanted) {
      return state->route;
    }
  }
}

TEST(AgentCommands, AStoppedRouteIsTakenUpByResume) {
  SteppingAgent agent;
  agent.navigator.may_arrive = false;
  ASSERT_TRUE(agent.commands.RunRoute(ThereAndBack(), 0).ok());
  const auto driving = RouteThatIs(agent.hub, routes::RouteState::kDriving);
  ASSERT_TRUE(driving.has_value());
  // It is shown as any goal is.
  const auto poses = agent.commands.PosesOf(driving->goal_id);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].map_from_base.translation, (geometry::Vec2{1, 0}));
  ASSERT_TRUE(agent.commands.Stop("a child").ok());
  ASSERT_TRUE(RouteThatIs(agent.hub, routes::RouteState::kHeld).has_value());
  EXPECT_TRUE(absl::IsFailedPrecondition(agent.commands.Resume()));
  EXPECT_TRUE(absl::IsFailedPrecondition(agent.commands.ResumeRoute()));
  EXPECT_TRUE(absl::IsFailedPrecondition(
      agent.commands.RunRoute(ThereAndBack(), 0).status()));
  ASSERT_TRUE(agent.commands.Release().ok());
  ASSERT_TRUE(agent.commands.Resume().ok());
  EXPECT_TRUE(RouteThatIs(agent.hub, routes::RouteState::kDriving).has_value());
}

TEST(AgentCommands, ResumeAndCancelAreOfAnotherGoalFirst) {
  SteppingAgent agent;
  agent.navigator.may_arrive = false;
  ASSERT_TRUE(agent.commands.RunRoute(ThereAndBack(), 0).ok());
  ASSERT_TRUE(RouteThatIs(agent.hub, routes::RouteState::kDriving).has_value());
  const auto goal = agent.commands.SetGoal({{.x_m = 1, .y_m = 1}});
  ASSERT_TRUE(goal.ok());
  ASSERT_TRUE(RouteThatIs(agent.hub, routes::RouteState::kHeld).has_value());
  ASSERT_TRUE(agent.commands.Resume().ok());
  EXPECT_TRUE(RouteThatIs(agent.hub, routes::RouteState::kHeld).has_value());
  ASSERT_TRUE(agent.commands.Cancel(0).ok());
  EXPECT_TRUE(RouteThatIs(agent.hub, routes::RouteState::kHeld).has_value());
  ASSERT_TRUE(agent.commands.Cancel(0).ok());
  EXPECT_TRUE(
      RouteThatIs(agent.hub, routes::RouteState::kCancelled).has_value());
  EXPECT_TRUE(absl::IsNotFound(agent.commands.Cancel(0)));
  EXPECT_TRUE(absl::IsNotFound(agent.commands.ResumeRoute()));
}

TEST(AgentCommands, ARouteEndsWithItsGoalAndByItsNumber) {
  SteppingAgent agent;
  agent.navigator.may_arrive = false;
  const auto id = agent.commands.RunRoute(ThereAndBack(), 1);
  ASSERT_TRUE(id.ok());
  const auto driving = RouteThatIs(agent.hub, routes::RouteState::kDriving);
  ASSERT_TRUE(driving.has_value());
  EXPECT_EQ(driving->progress.waypoint, 1U);
  EXPECT_TRUE(absl::IsNotFound(agent.commands.CancelRoute(*id + 1)));
  ASSERT_TRUE(agent.commands.Cancel(driving->goal_id).ok());
  EXPECT_TRUE(
      RouteThatIs(agent.hub, routes::RouteState::kCancelled).has_value());
  EXPECT_TRUE(absl::IsNotFound(agent.commands.CancelRoute(*id)));
  EXPECT_TRUE(absl::IsInvalidArgument(
      agent.commands.RunRoute(ThereAndBack(), 2).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(agent.commands.RunRoute({}, 0).status()));
}

TEST(AgentCommands, AStopHoldsUntilItIsReleased) {
  SteppingAgent agent;
  const auto kept = agent.commands.Stop("a child");
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_THAT(std::string(kept->status.message()), HasSubstr("--state-dir"));
  EXPECT_TRUE(absl::IsFailedPrecondition(
      agent.commands.SetGoal({{.x_m = 0.5}}).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(agent.commands.Drive({}, "me", 1)));
  EXPECT_TRUE(agent.commands.Release().ok());
  EXPECT_TRUE(agent.commands.SetGoal({{.x_m = 0.5}}).ok());
  EXPECT_TRUE(absl::IsInvalidArgument(
      agent.commands.Stop(std::string(201, 'x')).status()));
}

TEST(AgentCommands, AStopIsKeptEvenIfNoStepTakesIt) {
  const base::TestingFolder folder;
  StopFile stops(folder.path());
  AgentHub hub({.patience = absl::Milliseconds(5)});
  const AgentInfo info = TestInfo();
  AgentCommands commands(hub, info, nullptr, &stops);
  EXPECT_TRUE(absl::IsDeadlineExceeded(commands.Stop("a child").status()));
  EXPECT_TRUE(StopFile(folder.path()).why().has_value());
  // What begins later finds it.
  FakeNavigator navigator;
  commands.StopAsKept(navigator);
  EXPECT_TRUE(navigator.snapshot.stop.has_value());
  // So it is after a release that no step takes.
  EXPECT_TRUE(absl::IsDeadlineExceeded(commands.Release().status()));
  EXPECT_TRUE(StopFile(folder.path()).why().has_value());
}

TEST(AgentCommands, AHandDrivesWithANameAndInOrder) {
  SteppingAgent agent;
  const core::VelocityCommand ahead = {.forward_mps = 0.2, .yaw_rate_radps = 0};
  EXPECT_TRUE(agent.commands.Drive(ahead, "me", 2).ok());
  EXPECT_TRUE(absl::IsAborted(agent.commands.Drive(ahead, "me", 2)));
  EXPECT_TRUE(absl::IsInvalidArgument(agent.commands.Drive(ahead, "", 3)));
  agent.Close();
  EXPECT_EQ(agent.navigator.snapshot.command, ahead);
}

}  // namespace
}  // namespace treeline::agent_service

#include "nav_agent/service/navigation_wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::ElementsAre;

TEST(NavigationWire, EnumeratorsHaveTheirOwnNames) {
  EXPECT_EQ(ToProto(behavior::NavigatorMode::kIdle), v1::NAVIGATOR_MODE_IDLE);
  EXPECT_EQ(ToProto(behavior::NavigatorMode::kNeedHelp),
            v1::NAVIGATOR_MODE_NEED_HELP);
  EXPECT_EQ(ToProto(behavior::GoalState::kAccepted), v1::GOAL_STATE_ACCEPTED);
  EXPECT_EQ(ToProto(behavior::GoalState::kCancelled), v1::GOAL_STATE_CANCELLED);
  EXPECT_EQ(ToProto(core::NavigationCause::kLaserLost),
            v1::NAVIGATION_CAUSE_LASER_LOST);
  EXPECT_EQ(FromProto(v1::NAVIGATOR_MODE_LOST), behavior::NavigatorMode::kLost);
  EXPECT_EQ(FromProto(v1::GOAL_STATE_ACTIVE), behavior::GoalState::kActive);
  EXPECT_EQ(FromProto(v1::NAVIGATION_CAUSE_TILTED),
            core::NavigationCause::kTilted);
}

TEST(NavigationWire, AFixIsTheRobotsPoseToo) {
  AgentState state;
  const geometry::Rigid3 map_from_base = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, 0.7}),
      .translation = {3, 4, 0}};
  core::RelocalizationAnswer fix;
  fix.localized = true;
  fix.map_from_camera = map_from_base * core::RobotModel().base_from_camera;
  state.snapshot.fix = fix;
  const v1::RobotState proto = StateToProto(TestInfo(), state);
  EXPECT_NEAR(proto.fix().map_from_base().x_m(), 3, 1e-9);
  EXPECT_NEAR(proto.fix().map_from_base().y_m(), 4, 1e-9);
  EXPECT_NEAR(proto.fix().map_from_base().yaw_rad(), 0.7, 1e-9);
  state.snapshot.fix->localized = false;
  state.snapshot.fix->reason = "TOO_FEW_INLIERS";
  const v1::RobotState without = StateToProto(TestInfo(), state);
  EXPECT_FALSE(without.fix().has_map_from_base());
  EXPECT_EQ(without.fix().reason(), "TOO_FEW_INLIERS");
}

TEST(NavigationWire, TextIsUtf8WhateverADeviceSays) {
  AgentState state;
  state.devices = {{"laser", "lost", "\xff broken"}};
  const v1::RobotState proto = StateToProto(TestInfo(), state);
  EXPECT_EQ(proto.devices(0).cause(), "\xEF\xBF\xBD broken");
}

TEST(NavigationWire, ASceneIsFlatWhereItIsLarge) {
  AgentState state;
  state.snapshot.scan_in_map = {{1, 2}, {3, 4}};
  state.snapshot.tree_edges = {{0, 0}, {1, 1}};
  state.snapshot.costmap.width = 2;
  state.snapshot.costmap.height = 1;
  state.snapshot.costmap.cells = {0, 2};
  const v1::RobotScene proto = SceneToProto(state);
  EXPECT_THAT(proto.scan_m(), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(proto.tree_edges_m(), ElementsAre(0, 0, 1, 1));
  EXPECT_EQ(proto.costmap().cells(), std::string("\0\2", 2));
  // Not one that does not fit its measures.
  state.snapshot.costmap.width = 3;
  EXPECT_FALSE(SceneToProto(state).has_costmap());
}

}  // namespace
}  // namespace treeline::agent_service

#include "nav_agent/mapless/body_shape.h"

#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/mapless/testing_clutter.h"

namespace treeline::mapless {
namespace {

// Of cells: where something is in them, and which of a rim is nearest.
constexpr double kCells_m = 2 * kCell_m;

TEST(BodyShape, RoomIsThatBesideTheBodyAsItStands) {
  EvidenceGrid map;
  AddWall({-2, 0.4}, {2, 0.4}, map);
  const ClearanceWindow clearance(map, {-3, -3}, {3, 3});
  const BodyShape body(SmallRobot(), 0);
  // Along the wall its side is 0.2 m off, across it its front 0.15 m.
  EXPECT_NEAR(body.RoomAt_m(clearance, {{0, 0}, 0}, 1), 0.2, kCells_m);
  EXPECT_NEAR(body.RoomAt_m(clearance, {{0, 0}, std::numbers::pi / 2}, 1), 0.15,
              kCells_m);
  EXPECT_LT(body.RoomAt_m(clearance, {{0, 0.3}, 0}, 1), 0);
  EXPECT_EQ(body.RoomAt_m(clearance, {{0, -2}, 0}, 0.3), 0.3);
}

TEST(BodyShape, ACornerTouchesWhereTheSideDoesNot) {
  EvidenceGrid map;
  AddWall({-2, 0.29}, {2, 0.29}, map);
  AddWall({-2, -0.29}, {2, -0.29}, map);
  const ClearanceWindow clearance(map, {-3, -3}, {3, 3});
  const BodyShape body(SmallRobot(), kBodyMargin_m);
  EXPECT_GE(body.RoomAt_m(clearance, {{0, 0}, 0}, 1), 0);
  // Its corner reaches 0.32 m to the side.
  EXPECT_LT(body.RoomAt_m(clearance, {{0, 0}, 0.9}, 1), 0);
}

TEST(BodyShape, AMarginIsTakenOffTheRoom) {
  EvidenceGrid map;
  AddWall({-2, 0.4}, {2, 0.4}, map);
  const ClearanceWindow clearance(map, {-3, -3}, {3, 3});
  const BodyShape body(SmallRobot(), 0.1);
  EXPECT_NEAR(body.RoomAt_m(clearance, {{0, 0}, 0}, 1), 0.1, kCells_m);
  EXPECT_NEAR(body.inner_m(), 0.3, 1e-9);
}

}  // namespace
}  // namespace treeline::mapless

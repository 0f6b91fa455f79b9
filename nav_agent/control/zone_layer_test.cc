#include "nav_agent/control/zone_layer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/control/local_controller.h"
#include "nav_agent/control/testing_floor.h"

namespace treeline::control {
namespace {

using zones::Zone;
using zones::ZoneKind;
using zones::ZoneMap;

const core::RobotModel kRobot;
constexpr double kPi = std::numbers::pi;

Zone Box(ZoneKind kind, geometry::Vec2 low, geometry::Vec2 high) {
  return {.name = "box",
          .kind = kind,
          .level = 0,
          .corners_in_map = {low, {high.x, low.y}, high, {low.x, high.y}},
          .max_mps = 0.2};
}

std::shared_ptr<const ZoneMap> ZonesOf(const TestingFloor& floor,
                                       const std::vector<Zone>& zones) {
  const auto made = ZoneMap::Make(floor.Map()->traversable(), zones, {}, 0.6);
  EXPECT_TRUE(made.ok()) << made.status();
  return made.value_or(nullptr);
}

// 4 x 4 m about (6, 6), and a robot at a pose in it.
class Around {
 public:
  Around(const TestingFloor& floor, const std::vector<Zone>& zones)
      : ground_(floor.Map(), window_.cells()),
        layer_(window_.cells(), Footprint::Of(kRobot)) {
    ground_.Spread(window_, TestingPose(6, 6).pose);
    layer_.SetZones(ZonesOf(floor, zones));
    layer_.Spread(window_, ground_);
  }
  void Stand(double x, double y, double yaw_rad = 0) {
    core::LevelPose pose = TestingPose(x, y).pose;
    pose.map_from_base.yaw_rad = yaw_rad;
    layer_.LetOut(window_, ground_, pose);
  }
  bool IsClosed(double x, double y) const {
    const core::CellIndex cell = window_.CellOf({x, y});
    return layer_.IsClosed(window_.IndexOf(cell.x, cell.y));
  }
  ZoneLayer& layer() { return layer_; }

 private:
  CostmapWindow window_ = CostmapWindow(4, 4, 0.05).CenteredAt({6, 6});
  GroundLayer ground_;
  ZoneLayer layer_;
};

TEST(ZoneLayer, ClosesWhatTheRobotIsKeptOutOf) {
  Around around({}, {Box(ZoneKind::kKeepOut, {7, 4}, {9, 8})});
  around.Stand(6, 6);
  EXPECT_TRUE(around.IsClosed(7.5, 6));
  EXPECT_TRUE(around.IsClosed(7.02, 6));
  EXPECT_FALSE(around.IsClosed(6.9, 6));
}

TEST(ZoneLayer, LetsARobotOutThatStandsInAZoneAndNoFurtherIn) {
  // From x = 4.5 on: out is to the left.
  Around around({}, {Box(ZoneKind::kKeepOut, {4.5, 0}, {12, 12})});
  around.Stand(5.5, 6);
  EXPECT_FALSE(around.IsClosed(4.6, 6));
  EXPECT_FALSE(around.IsClosed(5.5, 6));
  EXPECT_TRUE(around.IsClosed(6.5, 6));
  // The nearer it is to the edge, the less is open.
  around.Stand(4.7, 6, kPi);
  EXPECT_FALSE(around.IsClosed(4.6, 6));
  EXPECT_TRUE(around.IsClosed(5.5, 6));
  // A part of it that is in is let out, too; then all is closed.
  around.Stand(4.3, 6, kPi);
  EXPECT_FALSE(around.IsClosed(4.55, 6));
  EXPECT_TRUE(around.IsClosed(5.0, 6));
  around.Stand(4.1, 6, kPi);
  EXPECT_TRUE(around.IsClosed(4.55, 6));
}

TEST(ZoneLayer, IsOpenWhereZonesAreOfAnotherKindOrNone) {
  Around around({}, {Box(ZoneKind::kSpeed, {4, 4}, {8, 8})});
  around.Stand(6, 6);
  EXPECT_FALSE(around.IsClosed(7, 6));
  EXPECT_NEAR(around.layer().MaxSpeed_mps(0, {6, 6}), 0.2, 1e-6);
  around.layer().SetZones(nullptr);
  EXPECT_TRUE(std::isinf(around.layer().MaxSpeed_mps(0, {6, 6})));
}

TEST(ZoneLayer, EdgesAreThoseOfAPoseElsewhere) {
  Around around({}, {Box(ZoneKind::kKeepOut, {1, 1}, {2, 2})});
  EXPECT_FALSE(around.layer().Edges(TestingPose(2.3, 1.5).pose, 0.6).empty());
  for (const geometry::Vec2& edge :
       around.layer().Edges(TestingPose(2.3, 1.5).pose, 0.6)) {
    EXPECT_GT(edge.x, 1.9);
  }
  EXPECT_TRUE(around.layer().Edges(TestingPose(1.5, 1.5).pose, 0.6).empty());
}

// A robot that does what it is told, in a floor without obstacles.
class Drive {
 public:
  Drive(const ControlPose& start, const std::vector<Zone>& zones)
      : pose_(start), zones_(ZonesOf(floor_, zones)) {
    controller_->SetZones(zones_);
  }
  ControlResult Step() {
    pose_.stamp += std::chrono::milliseconds(25);
    EXPECT_TRUE(
        controller_
            ->AddScan(pose_,
                      TestingScan(pose_, [](geometry::Vec2) { return false; }))
            .ok());
    const ControlResult result = controller_->Step(pose_);
    geometry::Rigid2& at = pose_.pose.map_from_base;
    at.yaw_rad += result.command.yaw_rate_radps * 0.025;
    at.translation = at * geometry::Vec2{result.command.forward_mps * 0.025, 0};
    pose_.forward_mps = result.command.forward_mps;
    pose_.yaw_rate_radps = result.command.yaw_rate_radps;
    return result;
  }
  void Goto(geometry::Vec2 goal) {
    core::LevelPose end;
    end.map_from_base = {.translation = goal, .yaw_rad = 0};
    controller_->SetPath({pose_.pose, end});
  }
  bool Touches() const {
    const std::vector<geometry::Vec2> area = Footprint::Of(kRobot).Area(0.02);
    return std::ranges::any_of(area, [this](geometry::Vec2 in_base) {
      return zones_->IsKeptOut(0, pose_.pose.map_from_base * in_base);
    });
  }
  ControlPose& pose() { return pose_; }
  LocalController& controller() { return *controller_; }
  void SetZones(const std::vector<Zone>& zones) {
    zones_ = ZonesOf(floor_, zones);
    controller_->SetZones(zones_);
  }

 private:
  TestingFloor floor_;
  std::unique_ptr<LocalController> controller_ = *LocalController::Make(
      floor_.Map(), kRobot, {.front = TestingLaser()}, {});
  ControlPose pose_;
  std::shared_ptr<const ZoneMap> zones_;
};

TEST(ZonesInControl, TheBandBendsAwayFromAZoneBesideItsPath) {
  // The path leaves 2 cm beside the footprint.
  Drive drive(TestingPose(3.5, 6),
              {Box(ZoneKind::kKeepOut, {5, 6.33}, {6, 8})});
  drive.Goto({7.5, 6});
  ControlResult result;
  double lowest_m = 6;
  for (int i = 0; i < 800 && result.state != ControlState::kArrived; ++i) {
    result = drive.Step();
    ASSERT_FALSE(drive.Touches());
    const geometry::Vec2 at = drive.pose().pose.map_from_base.translation;
    if (at.x > 5 && at.x < 6) lowest_m = std::min(lowest_m, at.y);
  }
  EXPECT_EQ(result.state, ControlState::kArrived);
  EXPECT_LT(lowest_m, 5.9);
}

TEST(ZonesInControl, APathIntoAZoneIsNotFollowed) {
  Drive drive(TestingPose(4, 6), {Box(ZoneKind::kKeepOut, {5, 0}, {6, 12})});
  drive.Goto({8, 6});
  ControlResult result;
  for (int i = 0; i < 600 && result.state != ControlState::kBlocked; ++i) {
    result = drive.Step();
    ASSERT_FALSE(drive.Touches());
  }
  EXPECT_EQ(result.state, ControlState::kBlocked);
}

TEST(ZonesInControl, ARobotThatStandsInAZoneDrivesOut) {
  Drive drive(TestingPose(4.4, 6), {Box(ZoneKind::kKeepOut, {3, 5}, {5, 7})});
  drive.Goto({6, 6});
  ControlResult result;
  bool is_out = false;
  for (int i = 0; i < 1200 && result.state != ControlState::kArrived; ++i) {
    result = drive.Step();
    is_out = is_out || !drive.Touches();
    ASSERT_FALSE(is_out && drive.Touches());
  }
  EXPECT_EQ(result.state, ControlState::kArrived);
}

TEST(ZonesInControl, NoManoeuvreHasRoomInAZone) {
  Drive drive(TestingPose(6, 6), {});
  drive.Step();
  EXPECT_NEAR(drive.controller().FreeWay_m(drive.pose(), -0.5), -0.5, 1e-6);
  drive.SetZones({Box(ZoneKind::kKeepOut, {2, 4}, {5.5, 8})});
  drive.Step();
  EXPECT_GT(drive.controller().FreeWay_m(drive.pose(), -0.5), -0.25);
  EXPECT_NEAR(drive.controller().FreeWay_m(drive.pose(), 0.5), 0.5, 1e-6);
}

TEST(ZonesInControl, ItIsAsSlowAsTheZoneFromItsEdgeOn) {
  Drive drive(TestingPose(4, 6), {Box(ZoneKind::kSpeed, {5.5, 4}, {6.5, 8})});
  drive.Goto({8.5, 6});
  double fastest_before_mps = 0;
  double fastest_after_mps = 0;
  ControlResult result;
  for (int i = 0; i < 1600 && result.state != ControlState::kArrived; ++i) {
    result = drive.Step();
    const double x = drive.pose().pose.map_from_base.translation.x;
    const double speed_mps = drive.pose().forward_mps;
    if (x < 5.2) fastest_before_mps = std::max(fastest_before_mps, speed_mps);
    if (x > 5.5 && x < 6.5) {
      EXPECT_LE(speed_mps, 0.2 + 1e-6) << x;
    }
    if (x > 6.7) fastest_after_mps = std::max(fastest_after_mps, speed_mps);
  }
  EXPECT_EQ(result.state, ControlState::kArrived);
  EXPECT_GT(fastest_before_mps, 0.55);
  EXPECT_GT(fastest_after_mps, 0.55);
}

}  // namespace
}  // namespace treeline::control

// People, tables, thin legs, low boxes: what a robot runs into and what runs
// into it.
#include <cmath>
#include <numbers>

#include "gtest/gtest.h"
#include "simulation/simulator/testing_simulator.h"

namespace treeline::simulator {
namespace {

constexpr double kPi = std::numbers::pi;

worlds::Motion Walk(worlds::Float3 from, worlds::Float3 to, double begin_s,
                    double end_s) {
  return {.keys = {{.time_s = begin_s, .world_from_body = {from, 0}},
                   {.time_s = end_s, .world_from_body = {to, 0}}}};
}

TEST(Collisions, APersonWhoWalksIntoAStandingRobotCausesIt) {
  const auto simulator = MakeSimulator(
      Hall().Body("person", Walk({5, 10, 0}, {15, 10, 0}, 0, 10)).Build(),
      StartAt(10, 10));
  simulator->Step(std::chrono::seconds(10));
  const auto hits = EventsOf(*simulator, SimEventKind::kCollision);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].what, "person");
  EXPECT_FALSE(hits[0].caused_by_robot);
  EXPECT_NEAR(hits[0].body_approach_mps, 1, 0.01);
  // The person's front is 0.2 m ahead, the robot's back 0.3 m behind it.
  EXPECT_NEAR(Seconds(hits[0].time), 4.5, 0.01);
  EXPECT_NEAR(hits[0].point_in_world.x, 9.7, 0.01);
  EXPECT_EQ(PositionOf(*simulator), (geometry::Vec3{10, 10, 0}));
}

TEST(Collisions, ARobotThatDrivesIntoAStandingPersonCausesItAndStops) {
  const auto simulator = MakeSimulator(
      Hall().Body("person", Walk({12, 10, 0}, {12, 10, 0}, 0, 1)).Build(),
      StartAt(10, 10));
  Drive(*simulator, {.forward_mps = 0.5}, 6);
  const auto hits = EventsOf(*simulator, SimEventKind::kCollision);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_TRUE(hits[0].caused_by_robot);
  EXPECT_NEAR(hits[0].robot_approach_mps, 0.5, 0.01);
  EXPECT_NEAR(PositionOf(*simulator).x, 12 - 0.2 - 0.3, 0.005);
  // Away from there it may go.
  Drive(*simulator, {.forward_mps = -0.3}, 3);
  EXPECT_LT(PositionOf(*simulator).x, 10.8);
}

TEST(Collisions, ATableTopIsInTheWayAndAHighShelfIsNot) {
  PlaceBuilder place = Hall();
  // A top of 2 cm at 0.72 m without anything below it.
  place.Box(worlds::SurfaceKind::kOther, {12, 9, 0.70f}, {13, 11, 0.72f}, true);
  place.Box(worlds::SurfaceKind::kOther, {7, 9, 1.30f}, {8, 11, 1.32f}, true);
  const auto simulator = MakeSimulator(place.Build(), StartAt(10, 10));
  Drive(*simulator, {.forward_mps = 0.5}, 6);
  const auto hits = EventsOf(*simulator, SimEventKind::kCollision);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].what, "furniture");
  EXPECT_NEAR(PositionOf(*simulator).x, 11.7, 0.005);
  ASSERT_TRUE(simulator->Kidnap({.position = {10, 10}, .yaw_rad = kPi}).ok());
  Drive(*simulator, {.forward_mps = 0.5}, 8);
  EXPECT_LT(PositionOf(*simulator).x, 7);
  EXPECT_TRUE(EventsOf(*simulator, SimEventKind::kCollision).empty());
}

TEST(Collisions, AThinLegIsHitByEveryPartOfTheFootprint) {
  // A leg of 1 cm; the robot turns on the spot beside it, drives past and at
  // it, always faster than half a centimetre in a step.
  PlaceBuilder place = Hall();
  place.Box(worlds::SurfaceKind::kOther, {12, 10, 0}, {12.01f, 10.01f, 0.7f});
  worlds::World world = place.Build();
  for (const double offset_m : {-0.30, -0.15, 0.0, 0.15, 0.30}) {
    const auto simulator = MakeSimulator(world, StartAt(10, 10 + offset_m));
    Drive(*simulator, {.forward_mps = 0.8}, 5);
    EXPECT_EQ(EventsOf(*simulator, SimEventKind::kCollision).size(), 1u)
        << offset_m;
    EXPECT_LT(PositionOf(*simulator).x, 11.75);
  }
  // Beside the footprint it passes.
  const auto passing = MakeSimulator(world, StartAt(10, 10.35));
  Drive(*passing, {.forward_mps = 0.8}, 5);
  EXPECT_TRUE(passing->TakeEvents().empty());
  // A corner of the rectangle, 0.43 m from the middle, sweeps over it.
  const auto turning = MakeSimulator(world, StartAt(11.62, 10));
  Drive(*turning, {.yaw_rate_radps = 1.5}, 3);
  EXPECT_EQ(EventsOf(*turning, SimEventKind::kCollision).size(), 1u);
}

TEST(Collisions, LowThingsAreClimbedOrPassedOverOrBumpedInto) {
  const auto drive_over = [](float height_m, float y0, float y1) {
    PlaceBuilder place = Hall();
    place.Box(worlds::SurfaceKind::kOther, {12, y0, 0}, {12.6f, y1, height_m});
    const auto simulator = MakeSimulator(place.Build(), StartAt(10, 10));
    double highest_m = 0;
    for (int i = 0; i < 50; ++i) {
      Drive(*simulator, {.forward_mps = 0.8}, 0.1);
      highest_m = std::max(highest_m, PositionOf(*simulator).z);
    }
    return std::pair(highest_m, EventsOf(*simulator, SimEventKind::kCollision));
  };
  // Lower than max_step_m: up and down again.
  const auto [climbed_m, no_hits] = drive_over(0.015f, 9, 11);
  EXPECT_NEAR(climbed_m, 0.015, 1e-6);
  EXPECT_TRUE(no_hits.empty());
  // Higher than that and lower than the body: the caster or a wheel hits it.
  const auto [level_m, hits] = drive_over(0.04f, 9, 11);
  EXPECT_LT(level_m, 1e-6);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].what, "low obstacle");
  // The same between the caster and a wheel: the body passes over it.
  EXPECT_TRUE(drive_over(0.04f, 10.08f, 10.18f).second.empty());
}

TEST(Collisions, OverlappingFloorsDoNotMatter) {
  PlaceBuilder place = Hall();
  place.Floor(2, 2, 18, 18, 2.7f).Ramp(8, 8, 12, 12, 0.9f, 1.3f);
  const worlds::World world = place.Build();
  const auto below = MakeSimulator(world, StartAt(5, 5));
  Drive(*below, {.forward_mps = 0.8}, 6);
  EXPECT_EQ(PositionOf(*below).z, 0);
  EXPECT_TRUE(below->TakeEvents().empty());
  const auto above = MakeSimulator(world, StartAt(5, 5, 0, 2.7));
  EXPECT_NEAR(PositionOf(*above).z, 2.7, 1e-6);
  Drive(*above, {.forward_mps = 0.8}, 6);
  EXPECT_NEAR(PositionOf(*above).z, 2.7, 1e-6);
  EXPECT_TRUE(above->TakeEvents().empty());
}

TEST(Collisions, TooSteepARampTipsTheRobotOver) {
  PlaceBuilder place;
  // 0.2 rad is within 0.28; then 0.32, and 0.45, which is more than half again.
  place.Floor(0, 0, 4, 20, 0)
      .Ramp(4, 0, 6, 20, 0, 0.4f)
      .Ramp(6, 0, 7, 20, 0.4f, 0.73f)
      .Ramp(7, 0, 12, 20, 0.73f, 3.1f);
  const auto simulator = MakeSimulator(place.Build(), StartAt(3, 5));
  Drive(*simulator, {.forward_mps = 0.5}, 12);
  const auto events = simulator->TakeEvents();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, SimEventKind::kSteep);
  EXPECT_EQ(events[1].kind, SimEventKind::kTipped);
  EXPECT_TRUE(simulator->state().is_fallen);
}

TEST(Kidnap, IsRefusedWhereTheRobotCannotBe) {
  const auto simulator = MakeSimulator(
      Hall().Body("person", Walk({15, 15, 0}, {15, 15, 0}, 0, 1)).Build(),
      StartAt(10, 10));
  const auto kidnap = [&](double x_m, double y_m) {
    return simulator->Kidnap({.position = {x_m, y_m}});
  };
  EXPECT_EQ(kidnap(0.1, 5).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(kidnap(0.27, 5).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(kidnap(15, 15).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(kidnap(30, 30).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(PositionOf(*simulator), (geometry::Vec3{10, 10, 0}));
  EXPECT_TRUE(kidnap(1, 5).ok());
  EXPECT_EQ(EventsOf(*simulator, SimEventKind::kPlaced).size(), 1u);
}

TEST(Stage, DoorsTurnAndObstaclesComeAndGo) {
  PlaceBuilder place = Hall();
  worlds::Motion shut;
  shut.keys = {{.time_s = 0, .world_from_body = {{12, 9.4f, 0}, 0}}};
  // A leaf of 1.2 m along y from its hinge.
  place.builder().BeginBody();
  place.builder().AddBox({}, {0, 0, 0}, {0.04f, 1.2f, 2},
                         {.sides = place.grey()});
  place.builder().EndBody("door", 1.2f, 2, shut);
  place.Body("crate", std::nullopt);
  const auto simulator = MakeSimulator(place.Build(), StartAt(10, 10));
  Drive(*simulator, {.forward_mps = 0.5}, 5);
  EXPECT_LT(PositionOf(*simulator).x, 11.71);
  EXPECT_EQ(EventsOf(*simulator, SimEventKind::kCollision).size(), 1u);
  ASSERT_TRUE(simulator->TurnDoor("door", -kPi / 2).ok());
  ASSERT_TRUE(
      simulator->AddObstacle("box", "crate", {.position = {16, 10}}).ok());
  EXPECT_FALSE(
      simulator->AddObstacle("box", "crate", {.position = {1, 1}}).ok());
  EXPECT_EQ(simulator->AddObstacle("b", "moon", {.position = {1, 1}}).code(),
            absl::StatusCode::kNotFound);
  Drive(*simulator, {.forward_mps = 0.5}, 12);
  EXPECT_NEAR(PositionOf(*simulator).x, 15.5, 0.01);
  const auto hits = EventsOf(*simulator, SimEventKind::kCollision);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].what, "box");
  ASSERT_TRUE(simulator->RemoveObstacle("box").ok());
  Drive(*simulator, {.forward_mps = 0.5}, 3);
  EXPECT_GT(PositionOf(*simulator).x, 16);
}

}  // namespace
}  // namespace treeline::simulator

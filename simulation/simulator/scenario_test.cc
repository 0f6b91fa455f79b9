#include "simulation/simulator/scenario.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/scenario_reader.h"
#include "simulation/simulator/testing_places.h"

namespace treeline::simulator {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kEverything = R"(
world: hall
seed: 7
people: false
duration_s: 20
start: {at: [5, 5], yaw_deg: 90}
errors: false
sensors: {laser: false, odometry_hz: 50}
robot: {max_forward_mps: 0.6}
actions:
  - {at_s: 9, door: {name: post, angle_deg: 90}}
  - {at_s: 0.5, drive: {forward_mps: 0.5, yaw_rate_radps: 0.1, for_s: 2}}
  - {at_s: 4, kidnap: {at: [12, 12], yaw_deg: 180}}
  - {at_s: 4.5, kidnap: {place: corner}}
  - {at_s: 5, fault: {target: laser, kind: silent, for_s: 1}}
  - {at_s: 5, fault: {target: odometry, kind: stamp_offset, seconds: -0.2}}
  - {at_s: 5.5, fault: {target: left_wheel, kind: slip, share: 0.5, for_s: 2}}
  - {at_s: 6, add_obstacle: {name: box, body: crate, at: [3, 3], yaw_deg: 45, scale: [2, 1, 1]}}
  - {at_s: 7, move: {name: box, at: [4, 4]}}
  - {at_s: 8, remove_obstacle: box}
  - {at_s: 9.5, release: post}
  - {at_s: 10, reset_odometry: true}
  - {at_s: 11, tour: {speed_mps: 0.4, corners: [[14, 12, 0], [14, 15, 0]]}}
  - {at_s: 19, stop: true}
)";

worlds::World HallWithBodies() {
  worlds::Motion stands;
  stands.keys = {{.time_s = 0, .world_from_body = {{17, 3, 0}, 0}}};
  PlaceBuilder place = Hall();
  place.Body("post", stands).Body("crate", std::nullopt);
  worlds::World world = place.Build();
  world.places = {{"corner", {{2, 17, 0}, 0}}};
  return world;
}

std::unique_ptr<Simulator> SimulatorFor(const Scenario& scenario) {
  SimulatorOptions options = scenario.options;
  options.start = *StartOf(scenario, HallWithBodies());
  auto simulator = Simulator::Create(HallWithBodies(), options);
  EXPECT_TRUE(simulator.ok()) << simulator.status();
  return simulator.ok() ? *std::move(simulator) : nullptr;
}

std::string ErrorOf(const std::string& text) {
  const auto scenario = ParseScenario(text, "s.yaml");
  return scenario.ok() ? "" : std::string(scenario.status().message());
}

TEST(Scenario, SaysInWhichStateTheWorldIs) {
  const auto scenario = ParseScenario(
      "world: cafe\nlighting: evening\nrearranged: {seed: 3, share: 0.4}\n",
      "s.yaml");
  ASSERT_TRUE(scenario.ok()) << scenario.status();
  EXPECT_EQ(scenario->world_options.lighting, building::Lighting::kEvening);
  EXPECT_EQ(scenario->world_options.rearranged,
            (worlds::Rearrangement{.seed = 3, .share = 0.4}));
  EXPECT_THAT(ErrorOf("lighting: dusk\n"), HasSubstr("s.yaml:1: "));
  EXPECT_THAT(ErrorOf("rearranged: {seed: 3, share: 2}\n"),
              HasSubstr("s.yaml:1: "));
}

TEST(Scenario, IsReadWithItsActionsInOrderOfTime) {
  const auto scenario = ParseScenario(kEverything, "s.yaml");
  ASSERT_TRUE(scenario.ok()) << scenario.status();
  EXPECT_EQ(scenario->world, "hall");
  EXPECT_EQ(scenario->options.seed, 7u);
  EXPECT_FALSE(scenario->world_options.with_people);
  EXPECT_EQ(scenario->duration, milliseconds(20000));
  EXPECT_NEAR(scenario->start->yaw_rad, 1.5708, 1e-4);
  EXPECT_FALSE(scenario->options.sensors.has_laser);
  EXPECT_EQ(scenario->options.robot.max_forward_mps, 0.6);
  EXPECT_EQ(scenario->options.errors.track, 0);
  ASSERT_EQ(scenario->actions.size(), 14u);
  EXPECT_EQ(scenario->actions[0].at, milliseconds(500));
  EXPECT_EQ(scenario->actions[13].at, milliseconds(19000));
  const auto& slip = std::get<FaultAction>(scenario->actions[5].what).fault;
  EXPECT_EQ(slip.target, FaultTarget::kLeftWheel);
  EXPECT_EQ(slip.amount, 0.5);
  EXPECT_EQ(slip.duration, milliseconds(2000));
}

TEST(Scenario, ErrorsSayWhereAndWhat) {
  EXPECT_THAT(ErrorOf("world: cafe\ncolour: red\n"), StartsWith("s.yaml:2: "));
  EXPECT_THAT(ErrorOf("seed: -1\n"), StartsWith("s.yaml:1: "));
  const std::string actions = "world: cafe\nactions:\n  - ";
  EXPECT_THAT(
      ErrorOf(actions + "{at_s: 1, fault: {target: laser, kind: stuck}}"),
      AllOf(StartsWith("s.yaml:3: "), HasSubstr("no fault 'stuck'")));
  EXPECT_THAT(
      ErrorOf(actions + "{at_s: 1, fault: {target: nose, kind: stuck}}"),
      HasSubstr("'nose' is none of laser"));
  EXPECT_THAT(ErrorOf(actions + "{at_s: 1}"), HasSubstr("one thing to do"));
  EXPECT_THAT(ErrorOf(actions + "{at_s: 1, stop: true, release: x}"),
              HasSubstr("one thing to do"));
  EXPECT_THAT(ErrorOf(actions + "{at_s: -1, stop: true}"),
              StartsWith("s.yaml:3: "));
  EXPECT_THAT(ErrorOf(actions + "{at_s: 1, kidnap: {yaw_deg: 3}}"),
              HasSubstr("either 'place' or 'at'"));
  EXPECT_THAT(ErrorOf("robot: {half_width_m: 0.1}\n"),
              AllOf(StartsWith("s.yaml:1: "), HasSubstr("wheels")));
}

TEST(Scenario, PlaysEverythingAtItsTime) {
  const auto scenario = ParseScenario(kEverything, "s.yaml");
  ASSERT_TRUE(scenario.ok());
  const auto simulator = SimulatorFor(*scenario);
  ScenarioPlayer player(*scenario, *simulator);
  player.Step(milliseconds(3500));
  // Driven for two seconds, then stopped: 0.5 m/s is reached after 0.625 s and
  // lost within 0.333 s.
  EXPECT_NEAR(simulator->state().distance_m, 1 - 0.156 + 0.083, 0.005);
  EXPECT_EQ(simulator->state().forward_mps, 0);
  player.Step(milliseconds(700));
  EXPECT_NEAR(simulator->state().world_from_base.translation.x, 12, 1e-9);
  player.Step(milliseconds(2300));
  EXPECT_NEAR(simulator->state().world_from_base.translation.y, 17, 1e-6);
  ASSERT_EQ(simulator->bodies().size(), 2u);
  EXPECT_EQ(simulator->bodies()[1].scale, (worlds::Float3{2, 1, 1}));
  player.Step(milliseconds(2000));
  EXPECT_EQ(simulator->bodies().size(), 1u);
  player.Step(milliseconds(11500));
  EXPECT_GT(simulator->state().distance_m, 1.5);
  std::vector<std::string> failures;
  for (const SimEvent& event : simulator->TakeEvents()) {
    if (event.kind == SimEventKind::kScenario) failures.push_back(event.what);
  }
  EXPECT_THAT(failures, testing::IsEmpty());
}

TEST(Scenario, DoesNotDependOnHowTimeIsDivided) {
  const auto scenario = ParseScenario(kEverything, "s.yaml");
  const auto a = SimulatorFor(*scenario);
  const auto b = SimulatorFor(*scenario);
  ScenarioPlayer player_a(*scenario, *a);
  ScenarioPlayer player_b(*scenario, *b);
  player_a.Step(milliseconds(20000));
  SimTime left = milliseconds(20000);
  for (int i = 0; left > SimTime(0); ++i) {
    const SimTime part = std::min<SimTime>(left, SimTime(1'234'567 * (i % 40)));
    player_b.Step(part);
    left -= part;
  }
  EXPECT_EQ(a->state().world_from_base, b->state().world_from_base);
  EXPECT_EQ(a->state().distance_m, b->state().distance_m);
}

TEST(Scenario, WhatCannotBeDoneIsRecordedWithItsLine) {
  const auto scenario = ParseScenario(
      "start: {at: [5, 5]}\nactions:\n  - {at_s: 1, kidnap: {at: [0, 5]}}\n"
      "  - {at_s: 2, kidnap: {place: nowhere}}\n",
      "s.yaml");
  ASSERT_TRUE(scenario.ok()) << scenario.status();
  const auto simulator = SimulatorFor(*scenario);
  ScenarioPlayer player(*scenario, *simulator);
  player.Step(milliseconds(3000));
  const auto events = simulator->TakeEvents();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, SimEventKind::kScenario);
  EXPECT_THAT(events[0].what, StartsWith("line 3: no ground"));
  EXPECT_THAT(events[1].what, HasSubstr("it has corner"));
  EXPECT_NEAR(simulator->state().world_from_base.translation.x, 5, 1e-9);
}

TEST(TourDriver, FollowsALineWithoutLeavingIt) {
  const auto simulator = SimulatorFor(*ParseScenario(
      "start: {at: [3, 3]}\nerrors: false\nsensors: {laser: false}\n", "s"));
  const std::vector<geometry::Vec3> corners = {
      {3, 3, 0}, {10, 3, 0}, {10, 10, 0}, {3, 10, 0}, {9, 9.9, 0}};
  Scenario scenario;
  ScenarioPlayer player(scenario, *simulator);
  player.DriveTour({.options = {.speed_mps = 0.5}, .corners = corners});
  double max_reach_m = 0;
  for (int i = 0; i < 1000 && !player.is_tour_done(); ++i) {
    player.Step(milliseconds(100));
    const geometry::Vec3 at = simulator->state().world_from_base.translation;
    double nearest_m = 1e9;
    for (size_t c = 1; c < corners.size(); ++c) {
      const geometry::Vec3 way = corners[c] - corners[c - 1];
      const double t = std::clamp(
          Dot(at - corners[c - 1], way) / geometry::SquaredNorm(way), 0.0, 1.0);
      nearest_m = std::min(nearest_m, Norm(corners[c - 1] + t * way - at));
    }
    max_reach_m = std::max(max_reach_m, nearest_m);
  }
  EXPECT_TRUE(player.is_tour_done());
  // Corners are cut by less than the 0.5 m that it looks ahead.
  EXPECT_LT(max_reach_m, 0.4);
  EXPECT_TRUE(simulator->TakeEvents().empty());
}

TEST(TourDriver, ASurveyLooksAroundEverySoManyMetres) {
  const auto simulator = SimulatorFor(*ParseScenario(
      "start: {at: [3, 3]}\nerrors: false\nsensors: {laser: false}\n", "s"));
  ScenarioPlayer player(Scenario(), *simulator);
  player.DriveTour({.options = {.look_around_every_m = 2},
                    .corners = {{3, 3, 0}, {8, 3, 0}}});
  for (int i = 0; i < 900 && !player.is_tour_done(); ++i) {
    player.Step(milliseconds(100));
  }
  EXPECT_TRUE(player.is_tour_done());
  // At 0, 2 and 4 m of 5: three times around, each a little more than once
  // until the turn has stopped.
  const double turns = simulator->state().turned_rad / 6.283185307179586;
  EXPECT_GT(turns, 3);
  EXPECT_LT(turns, 3.6);
}

}  // namespace
}  // namespace treeline::simulator

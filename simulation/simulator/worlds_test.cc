// The worlds that we ship, driven through from end to end.
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/scenario_reader.h"

namespace treeline::simulator {
namespace {

using std::chrono::milliseconds;

class WorldsTest : public testing::TestWithParam<const char*> {};

TEST_P(WorldsTest, ATourNeitherHitsAnythingNorFalls) {
  worlds::World world =
      *worlds::MakeWorld(GetParam(), {.with_people = false, .paint = false});
  Scenario scenario;
  scenario.options.sensors.has_laser = false;
  scenario.options.seed = 3;
  scenario.options.start = *StartOf(scenario, world);
  const float lowest_m = world.tour.front().z;
  float highest_m = lowest_m;
  for (const worlds::Float3& corner : world.tour) {
    highest_m = std::max(highest_m, corner.z);
  }
  const auto simulator = *Simulator::Create(std::move(world), scenario.options);
  ScenarioPlayer player(scenario, *simulator);
  player.DriveTour({});
  double climbed_m = lowest_m;
  // A minute to spare, at a third of the tour's speed.
  const double patience_s = 60 + player.tour()->length_m() / 0.15;
  while (!player.is_tour_done() && Seconds(simulator->now()) < patience_s) {
    player.Step(milliseconds(200));
    climbed_m =
        std::max(climbed_m, simulator->state().world_from_base.translation.z);
  }
  EXPECT_TRUE(player.is_tour_done());
  // It was everywhere that the tour leads to.
  EXPECT_NEAR(climbed_m, highest_m, 0.02);
  std::string events;
  for (const SimEvent& event : simulator->TakeEvents()) {
    events += std::string(SimEventName(event.kind)) + " " + event.what + "; ";
  }
  EXPECT_EQ(events, "");
}

INSTANTIATE_TEST_SUITE_P(Shipped, WorldsTest,
                         testing::Values("cafe", "lab", "office-floor",
                                         "two-storey", "seed:1", "seed:7"));

TEST(Cafe, ItsPeopleAreHitByWhoDoesNotLook) {
  worlds::World world = *worlds::MakeWorld("cafe", {.paint = false});
  Scenario scenario;
  scenario.options.sensors.has_laser = false;
  scenario.options.start = *StartOf(scenario, world);
  const auto simulator = *Simulator::Create(std::move(world), scenario.options);
  ScenarioPlayer player(scenario, *simulator);
  TourAction tour;
  tour.options.repeats = true;
  player.DriveTour(tour);
  player.Step(std::chrono::minutes(5));
  int collisions = 0;
  for (const SimEvent& event : simulator->TakeEvents()) {
    collisions += event.kind == SimEventKind::kCollision ? 1 : 0;
    EXPECT_NE(event.what, "furniture");
    EXPECT_NE(event.what, "wall");
  }
  EXPECT_GT(collisions, 0);
}

TEST(ScenarioExample, OfTheDocumentationDoesWhatItSays) {
  auto scenario = ReadScenario(std::string(TREELINE_DOCS_FOLDER) +
                               "/scenario-example.yaml");
  ASSERT_TRUE(scenario.ok()) << scenario.status();
  worlds::World world = *worlds::MakeWorld(scenario->world, {.paint = false});
  scenario->options.start = *StartOf(*scenario, world);
  scenario->options.sensors.has_laser = false;
  const auto simulator =
      *Simulator::Create(std::move(world), scenario->options);
  ScenarioPlayer player(*scenario, *simulator);
  player.Step(scenario->duration);
  int placed = 0;
  for (const SimEvent& event : simulator->TakeEvents()) {
    EXPECT_NE(event.kind, SimEventKind::kScenario) << event.what;
    placed += event.kind == SimEventKind::kPlaced ? 1 : 0;
  }
  EXPECT_EQ(placed, 1);
  EXPECT_TRUE(simulator->IsServerDead());
}

}  // namespace
}  // namespace treeline::simulator

// Buildings as worlds: the shipped ones, and the generator's.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/building/plan_file.h"
#include "simulation/building/shipped_worlds.h"
#include "simulation/worlds/building_maker.h"
#include "simulation/worlds/generated_world.h"
#include "simulation/worlds/ground_truth.h"
#include "simulation/worlds/world.h"

namespace treeline::worlds {
namespace {

using ::testing::HasSubstr;

constexpr double kRobotRadius_m = 0.36;
constexpr WorldOptions kBare = {.threads = 1, .paint = false};

World Make(absl::string_view name, const WorldOptions& options = kBare) {
  auto world = MakeWorld(name, options);
  EXPECT_TRUE(world.ok()) << world.status();
  return *std::move(world);
}

GroundTruth TruthOf(const World& world) {
  auto truth = GroundTruth::Compute(world, GroundTruthOptions());
  EXPECT_TRUE(truth.ok()) << truth.status();
  return *std::move(truth);
}

// What every building must be.
void ExpectSound(const World& world) {
  SCOPED_TRACE(world.name);
  ASSERT_FALSE(world.surfaces.empty());
  const auto is_outside = [](float value, float size) {
    return value < -0.01f || value > size + 0.01f;
  };
  for (const Surface& surface : world.surfaces) {
    const Float3 normal = surface.Normal();
    ASSERT_NEAR(Norm(normal), 1, 1e-3) << "a sliver";
    for (const Float3& corner : surface.corners) {
      ASSERT_LT(std::abs(Dot(normal, corner - surface.corners[0])), 2e-4f);
      ASSERT_FALSE(is_outside(corner.x, world.size_m.x)) << corner.x;
      ASSERT_FALSE(is_outside(corner.y, world.size_m.y)) << corner.y;
      ASSERT_FALSE(is_outside(corner.z, world.size_m.z)) << corner.z;
    }
  }
  const auto crate =
      std::find_if(world.bodies.begin(), world.bodies.end(),
                   [](const Body& body) { return body.name == "crate"; });
  ASSERT_NE(crate, world.bodies.end());
  EXPECT_FALSE(crate->motion.has_value());

  const GroundTruth truth = TruthOf(world);
  const auto reach =
      truth.ReachableFrom(world.places[0].placement.origin, kRobotRadius_m);
  for (const NamedPlace& place : world.places) {
    const auto index = truth.Find(place.placement.origin);
    ASSERT_TRUE(index.has_value()) << place.name;
    EXPECT_EQ(truth.at(*index).state, GroundState::kFree) << place.name;
    EXPECT_TRUE(reach.Contains(*index)) << place.name;
  }
  for (size_t i = 0; i < world.tour.size(); ++i) {
    const std::vector<Float3> leg = {world.tour[i],
                                     world.tour[(i + 1) % world.tour.size()]};
    EXPECT_TRUE(truth.IsDriveable(leg, kRobotRadius_m))
        << "from " << leg[0].x << ", " << leg[0].y << " to " << leg[1].x << ", "
        << leg[1].y;
  }
  for (const GroundLevel& level : truth.levels()) {
    for (const GroundCell& cell : level.cells) {
      if (cell.kind == SurfaceKind::kStair) {
        ASSERT_NE(cell.state, GroundState::kFree);
      }
    }
  }
}

TEST(BuildingTest, ShippedWorldsAreSoundAndHaveTheirSizes) {
  const std::map<std::string, Float3> sizes = {{"cafe", {13, 10, 3}},
                                               {"lab", {11, 5, 3}},
                                               {"office-floor", {30, 20, 2.8f}},
                                               {"two-storey", {18, 12, 5.6f}}};
  ASSERT_EQ(building::ShippedWorlds().size(), sizes.size());
  for (const auto& [name, size] : sizes) {
    const World world = Make(name);
    EXPECT_EQ(world.name, name);
    EXPECT_EQ(world.size_m, size);
    EXPECT_EQ(world.walk_area.half_x_m, 0);
    ExpectSound(world);
    // With what has been moved, too, places are places.
    const World moved =
        Make(name, {.after_moves = true, .threads = 1, .paint = false});
    EXPECT_EQ(moved.surfaces.size(), world.surfaces.size());
    const GroundTruth truth = TruthOf(moved);
    for (const NamedPlace& place : moved.places) {
      EXPECT_TRUE(truth.Find(place.placement.origin).has_value());
    }
  }
}

TEST(BuildingTest, RampsHaveTheSlopesOfTheirFiles) {
  for (const building::ShippedWorld& shipped : building::ShippedWorlds()) {
    const auto plan = building::ParsePlan(shipped.text, shipped.name);
    ASSERT_TRUE(plan.ok()) << plan.status();
    const World world = Make(shipped.name);
    const GroundTruth truth = TruthOf(world);
    for (const building::PlanRamp& ramp : plan->ramps) {
      // As flat as robots need it: 1:8 to 1:12.
      EXPECT_GE(ramp.Slope(), 1.0 / 12 - 1e-9) << shipped.name;
      EXPECT_LE(ramp.Slope(), 1.0 / 8 + 1e-9) << shipped.name;
      EXPECT_GE(ramp.width_m, shipped.name == "lab" ? 0.95 : 1.2);
      const Float3 middle = {
          static_cast<float>((ramp.from.x_m + ramp.to.x_m) / 2),
          static_cast<float>((ramp.from.y_m + ramp.to.y_m) / 2),
          static_cast<float>((*ramp.from.z_m + *ramp.to.z_m) / 2)};
      const auto index = truth.Find(middle);
      ASSERT_TRUE(index.has_value()) << shipped.name;
      EXPECT_EQ(truth.at(*index).kind, SurfaceKind::kRamp);
      EXPECT_EQ(truth.at(*index).state, GroundState::kFree);
      EXPECT_NEAR(std::tan(truth.at(*index).slope_rad), ramp.Slope(), 1e-5);
    }
  }
}

TEST(BuildingTest, NothingButTheRampLeadsToTheCafesTerrace) {
  World world = Make("cafe");
  const Float3 terrace = {10.4f, 1.4f, 0.51f};
  const Float3 entrance = world.places[0].placement.origin;
  // Even for a robot without width.
  const GroundTruth truth = TruthOf(world);
  const auto reach = truth.ReachableFrom(entrance, 0);
  const auto goal = truth.Find(terrace);
  ASSERT_TRUE(goal.has_value());
  EXPECT_TRUE(reach.Contains(*goal));

  std::erase_if(world.surfaces, [](const Surface& surface) {
    return surface.kind == SurfaceKind::kRamp;
  });
  const GroundTruth without = TruthOf(world);
  const auto still = without.Find(terrace);
  ASSERT_TRUE(still.has_value());
  EXPECT_FALSE(without.ReachableFrom(entrance, 0).Contains(*still));
}

TEST(BuildingTest, TheUpperStoreyLiesOverTheLowerOne) {
  const World world = Make("two-storey");
  const GroundTruth truth = TruthOf(world);
  ASSERT_EQ(truth.levels().size(), 2u);
  const auto below = truth.Find({7, 7, 0});
  const auto above = truth.Find({7, 7, 2.6f});
  ASSERT_TRUE(below.has_value());
  ASSERT_TRUE(above.has_value());
  EXPECT_NE(below->level, above->level);
  EXPECT_NEAR(truth.at(*below).clearance_m, 2.4, 1e-3);
}

TEST(BuildingTest, MovedThingsMoveAndNothingElseDoes) {
  const World before = Make("lab");
  const World after =
      Make("lab", {.after_moves = true, .threads = 1, .paint = false});
  ASSERT_EQ(before.surfaces.size(), after.surfaces.size());
  size_t moved = 0;
  for (size_t i = 0; i < before.surfaces.size(); ++i) {
    moved += before.surfaces[i].corners != after.surfaces[i].corners;
  }
  EXPECT_GT(moved, 10u);
  EXPECT_LT(moved, before.surfaces.size() / 4);
}

TEST(BuildingTest, PeopleWalkOnTheGroundAndCanBeLeftOut) {
  const World world = Make("office-floor");
  const GroundTruth truth = TruthOf(world);
  size_t people = 0;
  for (const Body& body : world.bodies) {
    if (!body.motion.has_value() || body.name.starts_with("door")) continue;
    ++people;
    ASSERT_GT(body.motion->period_s, body.motion->keys.back().time_s);
    for (double t = 0; t < body.motion->period_s; t += 0.5) {
      const Placement at = body.motion->At(t);
      EXPECT_TRUE(truth.Find(at.origin).has_value())
          << body.name << " at " << t << " s";
    }
    for (const Surface& surface : body.surfaces) {
      for (const Float3& corner : surface.corners) {
        EXPECT_LE(std::hypot(corner.x, corner.y), body.radius_m + 1e-3f);
        EXPECT_LE(corner.z, body.height_m + 1e-3f);
      }
    }
  }
  EXPECT_EQ(people, 3u);
  const World without = Make(
      "office-floor", {.with_people = false, .threads = 1, .paint = false});
  EXPECT_EQ(without.bodies.size() + people, world.bodies.size());
}

TEST(BuildingTest, AMovingDoorOpensAndCloses) {
  const World world = Make("office-floor");
  const auto door = std::find_if(
      world.bodies.begin(), world.bodies.end(),
      [](const Body& body) { return body.name.starts_with("door"); });
  ASSERT_NE(door, world.bodies.end());
  // Closed for 16 s, opens in 2, is open for 20, closes in 2.
  const float closed_rad = door->motion->At(5).yaw_rad;
  EXPECT_NEAR(door->motion->At(17).yaw_rad - closed_rad, 0.75f, 1e-4f);
  EXPECT_NEAR(door->motion->At(25).yaw_rad - closed_rad, 1.5f, 1e-4f);
  EXPECT_NEAR(door->motion->At(41).yaw_rad - closed_rad, 0, 1e-4f);
}

TEST(BuildingTest, DrawnBuildingsAreSoundAndUnlike) {
  std::set<std::string> texts;
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const auto plan = GeneratedPlan(seed);
    ASSERT_TRUE(plan.ok()) << plan.status();
    EXPECT_TRUE(texts.insert(building::PlanText(*plan)).second) << seed;
    EXPECT_GE(plan->rooms.size(), 2u);
    EXPECT_LE(plan->rooms.size(), 4u);
    EXPECT_GE(plan->ramps[0].Slope(), 1.0 / 12.1);
    EXPECT_LE(plan->ramps[0].Slope(), 1.0 / 8 + 1e-9);
    const auto world = MakeBuilding(absl::StrCat("seed:", seed), *plan, kBare);
    ASSERT_TRUE(world.ok()) << world.status();
    ExpectSound(*world);
    EXPECT_GT(world->surfaces.size(), 1000u);
    EXPECT_GT(world->textures.size(), 40u);
  }
}

TEST(BuildingTest, OfficesAreSound) {
  for (const char* name : {"office:100", "office:360:3"}) {
    const World world = Make(name);
    ExpectSound(world);
    EXPECT_GT(world.tour.size(), 8u);
  }
}

TEST(BuildingTest, OfficesHaveBounds) {
  for (const char* name : {"office:99", "office:1501:4", "office:-5"}) {
    EXPECT_THAT(std::string(MakeWorld(name, kBare).status().message()),
                HasSubstr("100 to 1500"));
  }
  for (const char* name :
       {"office:", "office:200:", "office:200:1:2", "office:big"}) {
    EXPECT_THAT(std::string(MakeWorld(name, kBare).status().message()),
                HasSubstr("there is no world"));
  }
}

TEST(BuildingTest, ASeedGivesTheSameWorldOnAnyNumberOfThreads) {
  const World one = Make("seed:4", {.threads = 1});
  const World two = Make("seed:4", {.threads = 2});
  ASSERT_EQ(one.surfaces.size(), two.surfaces.size());
  for (size_t i = 0; i < one.surfaces.size(); ++i) {
    ASSERT_EQ(one.surfaces[i].corners, two.surfaces[i].corners);
    ASSERT_EQ(one.surfaces[i].texture, two.surfaces[i].texture);
  }
  ASSERT_EQ(one.textures.size(), two.textures.size());
  for (size_t i = 0; i < one.textures.size(); ++i) {
    for (const float at : {0.1f, 0.37f, 0.81f}) {
      ASSERT_EQ(one.textures[i].Sample(at, 1 - at, 1),
                two.textures[i].Sample(at, 1 - at, 1));
    }
  }
}

TEST(BuildingTest, FilesAreWorldsToo) {
  const std::string path = ::testing::TempDir() + "/building_test_world.yaml";
  std::ofstream(path) << building::ShippedWorlds()[1].text;
  const World world = Make(path);
  EXPECT_EQ(world.size_m, (Float3{11, 5, 3}));

  std::ofstream(path) << "size: [1, 2]\n";
  EXPECT_EQ(MakeWorld(path, kBare).status().message(),
            path + ":1: 'size' must be a sequence of 3 numbers");
  EXPECT_EQ(MakeWorld("nowhere/x.yaml", kBare).status().code(),
            absl::StatusCode::kNotFound);
}

TEST(BuildingTest, UnknownNamesAreAnsweredWithWhatThereIs) {
  const absl::Status status = MakeWorld("caffe", kBare).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  for (const char* name :
       {"'caffe'", "cafe", "lab", "office-floor", "two-storey", "room:N",
        "seed:N", "office:M2", ".yaml"}) {
    EXPECT_THAT(status.message(), HasSubstr(name));
  }
}

}  // namespace
}  // namespace treeline::worlds

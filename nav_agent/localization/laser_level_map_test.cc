#include "nav_agent/localization/laser_level_map.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/localization/amcl.h"
#include "nav_agent/traversability/testing_scene.h"

namespace treeline::localization {
namespace {

using testing::HasSubstr;

constexpr double kUpperFloor_m = 2.013;
constexpr double kRampBegin_m = 3;
constexpr double kRampLength_m = 16;
constexpr double kLaser_m = 0.35;
const double kSlope_rad = std::atan(2.0 / kRampLength_m);

// A hall under an upper floor; along its south side a ramp of 1:8 leads up. Its
// walls differ from each other, and between the floors.
traversability::Scene MakeTwoFloors() {
  traversability::Scene scene = traversability::Scene::WithFloor(22, 7);
  scene.top_m = 4;
  scene.AddBox(traversability::BlockKind::kGround, {0, 2.5}, {22, 7},
               kUpperFloor_m, 0.2);
  scene.AddBox(traversability::BlockKind::kGround, {19, 0}, {22, 2.5},
               kUpperFloor_m, 0.2);
  scene.blocks.push_back(
      {.kind = traversability::BlockKind::kGround,
       .scene_from_block = {.translation = {kRampBegin_m + kRampLength_m / 2,
                                            1.3},
                            .yaw_rad = 0},
       .half_x_m = kRampLength_m / 2,
       .half_y_m = 1.2,
       .top_begin_m = traversability::Scene::kFloor_m,
       .top_end_m = kUpperFloor_m,
       .thickness_m = 0.15});
  // Sides lie within voxels, not between two: those are seen.
  for (const auto& [low, high] :
       std::vector<std::pair<geometry::Vec2, geometry::Vec2>>{
           {{0, 0}, {22, 0.12}},
           {{0, 6.88}, {22, 7}},
           {{0, 0}, {0.12, 7}},
           {{21.88, 0}, {22, 7}}}) {
    scene.AddBox(traversability::BlockKind::kObstacle, low, high, 3.9);
  }
  scene.AddBox(traversability::BlockKind::kObstacle, {6.02, 5.02}, {6.98, 6.88},
               1.7, 1.69);
  scene.AddBox(traversability::BlockKind::kObstacle, {14.02, 3.32},
               {14.38, 3.68}, 1.7, 1.69);
  scene.AddBox(traversability::BlockKind::kObstacle, {9.02, 6.02}, {9.48, 6.88},
               3.9, 1.88);
  scene.AddBox(traversability::BlockKind::kObstacle, {17.02, 4.52},
               {17.98, 4.98}, 3.9, 1.88);
  return scene;
}

struct Building {
  octree::VoxelMap voxels = traversability::Voxelize(MakeTwoFloors());
  traversability::TraversableMap levels =
      *traversability::ExtractTraversableMap(voxels);
  std::shared_ptr<const LaserLevelMap> map =
      std::make_shared<const LaserLevelMap>(
          *LaserLevelMap::Make(voxels, levels));
};

const Building& TheBuilding() {
  static const Building building;
  return building;
}

// Up the ramp, and how the robot leans there.
double GroundOnWay(double x_m) {
  const double share =
      std::clamp((x_m - kRampBegin_m) / kRampLength_m, 0.0, 1.0);
  return traversability::Scene::kFloor_m +
         share * (kUpperFloor_m - traversability::Scene::kFloor_m);
}
double PitchOnWay(double x_m) {
  return x_m > kRampBegin_m && x_m < kRampBegin_m + kRampLength_m ? -kSlope_rad
                                                                  : 0;
}

core::RangeSensorInfo Laser() {
  return {.angle_min_rad = -2.3,
          .angle_increment_rad = 4.6 / 120,
          .beams = 121,
          .range_min_m = 0.1,
          .range_max_m = 25,
          .beam_interval_s = 0,
          .scan_interval_s = 0.1};
}

const geometry::Rigid3 kBaseFromLaser = {.rotation = {},
                                         .translation = {0.2, 0, kLaser_m}};

// By small steps through the voxels, with 1 cm of noise.
core::LaserScan ScanOf(const octree::VoxelMap& voxels,
                       const geometry::Rigid3& map_from_laser,
                       base::Random& random) {
  const core::RangeSensorInfo info = Laser();
  core::LaserScan scan;
  for (int beam = 0; beam < info.beams; ++beam) {
    const double angle_rad = info.AngleOf_rad(beam);
    const geometry::Vec3 direction =
        map_from_laser.rotation *
        geometry::Vec3{std::cos(angle_rad), std::sin(angle_rad), 0};
    double range_m = info.range_min_m;
    while (range_m < info.range_max_m &&
           voxels.At(voxels.IndexOf(map_from_laser.translation +
                                    range_m * direction)) !=
               octree::Voxel::kOccupied) {
      range_m += 0.02;
    }
    scan.ranges_m.push_back(
        range_m < info.range_max_m
            ? static_cast<float>(range_m + 0.01 * random.NextGaussian())
            : core::kNoReturn);
  }
  return scan;
}

struct Climb {
  double worst_m = 0;
  double worst_height_m = 0;
  int first_level = -1;
  int last_level = -1;
  int max_on_ground = 0;
};

// From the lower floor up the ramp to the upper one, and there to the end.
Climb DriveUp(bool global, bool use_tilt) {
  const Building& building = TheBuilding();
  Amcl amcl = *Amcl::CreateOnLevels(building.map, {}, 7);
  base::Random random(5, 5);
  Climb climb;
  geometry::Rigid2 odom_from_base;
  if (global) {
    amcl.StartGlobalLocalization();
  } else {
    EXPECT_TRUE(amcl.SetPoseOnLevel({{1, 1.3}, 0}, 0,
                                    {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.005})
                    .ok());
  }
  for (double x_m = 1; x_m < 21; x_m += 0.25) {
    const geometry::Rotation3 level_from_base =
        geometry::Rotation3::FromAxisAngle({0, PitchOnWay(x_m), 0});
    const geometry::Rigid3 map_from_base = {
        .rotation = level_from_base,
        .translation = {x_m, 1.3, GroundOnWay(x_m)}};
    const core::LaserScan scan =
        ScanOf(building.voxels, map_from_base * kBaseFromLaser, random);
    const ScanPoints points =
        *PointsInSpace(scan, Laser(), kBaseFromLaser,
                       use_tilt ? level_from_base : geometry::Rotation3(), 60);
    const auto estimate = *amcl.Update(odom_from_base, points);
    odom_from_base =
        odom_from_base *
        geometry::Rigid2{
            .translation = {0.25 * (1.01 + 0.02 * random.NextGaussian()), 0},
            .yaw_rad = 0.003 * random.NextGaussian()};
    if (climb.first_level < 0) climb.first_level = estimate->place.level;
    climb.last_level = estimate->place.level;
    climb.max_on_ground =
        std::max(climb.max_on_ground, estimate->beams_on_ground);
    if (global && x_m < 12) continue;
    climb.worst_m = std::max(
        climb.worst_m, geometry::Norm(estimate->map_from_base.translation -
                                      geometry::Vec2{x_m, 1.3}));
    climb.worst_height_m =
        std::max(climb.worst_height_m,
                 std::abs(estimate->place.height_m - GroundOnWay(x_m)));
  }
  return climb;
}

TEST(LaserLevelMap, GroundGoesOnOverTheJoin) {
  const LaserLevelMap& map = *TheBuilding().map;
  ASSERT_EQ(map.levels(), 2);
  core::LevelPlace place = *map.GroundNear({1, 1.3}, 0);
  EXPECT_EQ(place.level, 0);
  for (double x_m = 1; x_m < 21; x_m += 0.05) {
    const auto next = map.GroundNear({x_m, 1.3}, place.height_m);
    ASSERT_TRUE(next.has_value()) << x_m;
    // A voxel, and what the slope makes of half a cell.
    EXPECT_NEAR(next->height_m, GroundOnWay(x_m), 0.06) << x_m;
    place = *next;
  }
  EXPECT_EQ(place.level, 1);
  // Two floors, one over the other, are kept apart.
  EXPECT_EQ(map.GroundNear({11, 5}, 0.1)->level, 0);
  EXPECT_EQ(map.GroundNear({11, 5}, 1.9)->level, 1);
  EXPECT_FALSE(map.GroundNear({11, 5}, 1.0).has_value());
  EXPECT_FALSE(map.GroundNear({-5, 5}, 0).has_value());
}

TEST(LaserLevelMap, KnowsGroundFromWalls) {
  const LaserLevelMap& map = *TheBuilding().map;
  EXPECT_TRUE(map.IsOnGround({11, 5, 0.05}, 0.1));
  EXPECT_TRUE(map.IsOnGround({11, 5, 2.0}, 0.1));
  EXPECT_TRUE(map.IsOnGround({11, 1.3, GroundOnWay(11)}, 0.1));
  EXPECT_FALSE(map.IsOnGround({11, 5, 0.4}, 0.1));
  EXPECT_FALSE(map.IsOnGround({100, 5, 0}, 0.1));
}

TEST(LaserLevelMap, EachHeightHasItsOwnField) {
  const LikelihoodField& field = TheBuilding().map->field();
  // The pillar on the lower floor is not on the upper one.
  const ScanPoints at_pillar = {.x_m = {14.03f}, .y_m = {3.5f}, .z_m = {0.5f}};
  float log = 0;
  field.LogLikelihoods(at_pillar, {}, {&log, 1}, 0);
  EXPECT_GT(log, field.LogAt(0.1));
  field.LogLikelihoods(at_pillar, {}, {&log, 1}, kUpperFloor_m);
  EXPECT_LT(log, field.LogAt(0.4));
  // In the middle of the upper floor's slab is nothing that a beam could meet.
  const ScanPoints in_slab = {.x_m = {11}, .y_m = {4.5f}, .z_m = {1.9f}};
  field.LogLikelihoods(in_slab, {}, {&log, 1}, 0);
  EXPECT_LT(log, field.LogAt(0.4));
}

TEST(LaserLevelMap, SumsAreThoseOfSinglePoints) {
  const LikelihoodField& field = TheBuilding().map->field();
  base::Random random(3, 1);
  ScanPoints points;
  for (int i = 0; i < 37; ++i) {
    points.x_m.push_back(static_cast<float>(random.NextUniform(-9, 9)));
    points.y_m.push_back(static_cast<float>(random.NextUniform(-9, 9)));
    points.z_m.push_back(static_cast<float>(random.NextUniform(-2, 5)));
  }
  PoseArrays poses;
  poses.Resize(50);
  int different = 0;
  std::vector<float> sums(50);
  std::vector<geometry::Rigid2> map_from_base;
  std::vector<double> grounds_m;
  for (size_t i = 0; i < 50; ++i) {
    map_from_base.push_back(
        {{random.NextUniform(0, 20), random.NextUniform(0, 7)},
         random.NextUniform(-3, 3)});
    grounds_m.push_back(random.NextUniform(0, 2));
    poses.Set(i, map_from_base[i], grounds_m[i]);
  }
  field.SumLogLikelihoods(points, poses, sums);
  for (size_t i = 0; i < 50; ++i) {
    std::vector<float> logs(points.size());
    field.LogLikelihoods(points, map_from_base[i], logs, grounds_m[i]);
    double sum = 0;
    for (const float log : logs) sum += log;
    // A point within rounding of a cell's side may be on either of them.
    different += std::abs(sums[i] - sum) > 1e-3 ? 1 : 0;
  }
  EXPECT_LE(different, 3);
}

TEST(LaserLevelMap, RefusesWhatDoesNotFit) {
  const Building& building = TheBuilding();
  const octree::VoxelMap coarse =
      traversability::Voxelize(MakeTwoFloors(), {}, 0.1);
  EXPECT_THAT(LaserLevelMap::Make(coarse, building.levels).status().message(),
              HasSubstr("another resolution?"));
  EXPECT_EQ(LaserLevelMap::Make(building.voxels, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  traversability::TraversableMap closed = building.levels;
  for (traversability::TraversableLevel& level : closed.levels) {
    for (core::Occupancy& cell : level.grid.cells)
      cell = core::Occupancy::kUnknown;
  }
  EXPECT_THAT(LaserLevelMap::Make(building.voxels, closed).status().message(),
              HasSubstr("none of the cells of 2 levels is free"));
  LaserLevelOptions options;
  options.max_bytes = 1 << 20;
  EXPECT_EQ(LaserLevelMap::Make(building.voxels, building.levels, options)
                .status()
                .code(),
            absl::StatusCode::kResourceExhausted);
  options = {};
  options.layer_m = 0;
  EXPECT_THAT(LaserLevelMap::Make(building.voxels, building.levels, options)
                  .status()
                  .message(),
              HasSubstr("layer_m"));
}

// A flat map of 5 x 3 cells with a post, whose corner is anywhere; its voxels
// are one layer, in its own frame.
struct FlatMap {
  octree::VoxelMap voxels =
      octree::VoxelMap::Make(0.05, {0, 0, 6}, {5, 3, 1}).value();
  traversability::TraversableMap levels;

  explicit FlatMap(const geometry::Rigid2& map_from_grid) {
    voxels.Set({3, 1, 0}, octree::Voxel::kOccupied);
    traversability::TraversableLevel level;
    level.grid = core::OccupancyGrid::Filled(5, 3, 0.05, map_from_grid,
                                             core::Occupancy::kFree);
    level.grid.Set({3, 1}, core::Occupancy::kOccupied);
    level.height_m.assign(15, 0);
    levels.levels.push_back(std::move(level));
  }
};

TEST(LaserLevelMap, CellsOfAFlatMapMayBeAnywhereAndTurned) {
  const geometry::Rigid2 map_from_grid = {.translation = {1.234, -0.517},
                                          .yaw_rad = 0.7};
  const FlatMap flat(map_from_grid);
  const auto map = LaserLevelMap::Make(flat.voxels, flat.levels);
  ASSERT_TRUE(map.ok()) << map.status();
  const auto log_at = [&map](geometry::Vec2 end, float height_m) {
    std::vector<float> logs(1);
    ScanPoints points;
    points.x_m = {static_cast<float>(end.x)};
    points.y_m = {static_cast<float>(end.y)};
    points.z_m = {height_m};
    map->field().LogLikelihoods(points, {}, logs);
    return logs[0];
  };
  const geometry::Vec2 post = map_from_grid * geometry::Vec2{0.175, 0.075};
  // However high the laser is.
  EXPECT_EQ(log_at(post, 0.1F), map->field().LogAt(0));
  EXPECT_EQ(log_at(post, 1.5F), map->field().LogAt(0));
  EXPECT_LT(log_at(map_from_grid * geometry::Vec2{0.025, 0.075}, 0.1F),
            map->field().LogAt(0.1));
  for (const double laser_m : {0.1, 0.3, 1.5}) {
    EXPECT_EQ(LaserSlice(flat.voxels, flat.levels.levels[0], laser_m).cells,
              flat.levels.levels[0].grid.cells)
        << laser_m;
  }
}

TEST(LaserLevelMap, VoxelsOfTheMapsFrameMustLieWhereTheCellsDo) {
  FlatMap flat({.translation = {0.1, 0.05}, .yaw_rad = 0});
  flat.voxels = octree::VoxelMap::Make(0.05, {2, 1, 6}, {5, 3, 1}).value();
  EXPECT_TRUE(LaserLevelMap::Make(flat.voxels, flat.levels).ok());
  flat.voxels = octree::VoxelMap::Make(0.05, {2, 2, 6}, {5, 3, 1}).value();
  EXPECT_THAT(LaserLevelMap::Make(flat.voxels, flat.levels).status().message(),
              HasSubstr("not of the same cells"));
}

TEST(LaserSlice, IsWhatALaserSeesFromTheGroundBelow) {
  const Building& building = TheBuilding();
  const core::OccupancyGrid lower =
      LaserSlice(building.voxels, building.levels.levels[0], kLaser_m);
  const core::OccupancyGrid upper =
      LaserSlice(building.voxels, building.levels.levels[1], kLaser_m);
  EXPECT_EQ(lower.At(lower.CellOf({14.03, 3.5})), core::Occupancy::kOccupied);
  EXPECT_EQ(upper.At(upper.CellOf({14.03, 3.5})), core::Occupancy::kFree);
  EXPECT_EQ(upper.At(upper.CellOf({17.5, 4.53})), core::Occupancy::kOccupied);
  EXPECT_EQ(lower.At(lower.CellOf({17.5, 4.53})), core::Occupancy::kFree);
  // The ramp is no obstacle to who is on it.
  EXPECT_EQ(lower.At(lower.CellOf({5, 1.3})), core::Occupancy::kFree);
}

TEST(AmclOnLevels, FollowsARobotUpTheRampToTheNextLevel) {
  const Climb climb = DriveUp(false, true);
  EXPECT_EQ(climb.first_level, 0);
  EXPECT_EQ(climb.last_level, 1);
  // Two cells of 5 cm, and the odometry's noise between two scans.
  EXPECT_LT(climb.worst_m, 0.15);
  EXPECT_LT(climb.worst_height_m, 0.1);
  // From below it looks at the ramp, from above over it; on it the beams to its
  // sides and behind end on the ground.
  EXPECT_GT(climb.max_on_ground, 5);
}

TEST(AmclOnLevels, TiltMattersOnTheRamp) {
  EXPECT_GT(DriveUp(false, false).worst_m, DriveUp(false, true).worst_m);
}

TEST(AmclOnLevels, FindsItsLevelFromNothing) {
  const Climb climb = DriveUp(true, true);
  EXPECT_EQ(climb.last_level, 1);
  EXPECT_LT(climb.worst_m, 0.15);
  EXPECT_LT(climb.worst_height_m, 0.1);
}

TEST(AmclOnLevels, RefusesPlacesWithoutGround) {
  Amcl amcl = *Amcl::CreateOnLevels(TheBuilding().map, {}, 1);
  EXPECT_THAT(amcl.SetPoseOnLevel({{11, 5}, 0}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1})
                  .message(),
              HasSubstr("no level has ground at 11, 5, height 1"));
  EXPECT_EQ(Amcl::CreateOnLevels(nullptr, {}, 1).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::localization

#include "nav_agent/app/lost_suite_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/base/status_macros.h"
#include "common/synthetic/ray_caster.h"

namespace treeline {
namespace {

constexpr double kResolution_m = 0.05;
// From so far apart places, in so many directions, rays are cast.
constexpr int kEveryCells = 7;
constexpr int kDirections = 720;
constexpr double kRange_m = 30;
constexpr double kHitShare = 0.25;
constexpr double kOpaqueShare = 0.75;
// Walls lie on the edges of the ground.
constexpr int kMarginCells = 10;
// What is this near the vertical is ground or the top of something.
constexpr float kLevelNormal = 0.5f;
constexpr double kRobotRadius_m = 0.45;

// How often rays ended in a cell, and how often they went through.
struct Votes {
  explicit Votes(size_t cells) : hits(cells), passes(cells) {}
  std::vector<int> hits;
  std::vector<int> passes;
};

std::vector<BodyInstance> StandingBodies(const World& world) {
  std::vector<BodyInstance> standing;
  for (const BodyInstance& instance : world.InstancesAt(0)) {
    const Body& body = world.bodies[static_cast<size_t>(instance.body)];
    const std::vector<Motion::Key>& keys = body.motion->keys;
    if (std::ranges::all_of(keys, [&keys](const Motion::Key& key) {
          return key.world_from_body.origin == keys[0].world_from_body.origin;
        })) {
      standing.push_back(instance);
    }
  }
  return standing;
}

// The end of one ray is noted, and all that it went through.
void Vote(const OccupancyGrid& map, Vec2 from, Vec2 direction, double range_m,
          bool ends_there, Votes& votes) {
  const double half_m = map.resolution_m / 2;
  CellIndex last = {-1, -1};
  for (double along_m = 0; along_m < range_m - half_m; along_m += half_m) {
    const CellIndex cell = map.CellOf(from + along_m * direction);
    if (cell == last || !map.Contains(cell)) continue;
    ++votes.passes[map.IndexOf(cell)];
    last = cell;
  }
  if (!ends_there) return;
  const CellIndex end = map.CellOf(from + (range_m + 0.01) * direction);
  if (map.Contains(end)) ++votes.hits[map.IndexOf(end)];
}

std::vector<Float3> AllAround() {
  std::vector<Float3> directions;
  for (int i = 0; i < kDirections; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kDirections;
    directions.push_back({static_cast<float>(std::cos(angle_rad)),
                          static_cast<float>(std::sin(angle_rad)), 0});
  }
  return directions;
}

LaserMap MapLevel(const World& world, const WorldSnapshot& snapshot,
                  const GroundTruth& truth, const GroundLevel& level,
                  double laser_height_m) {
  OccupancyGrid map =
      OccupancyGrid::Filled(truth.width() + 2 * kMarginCells,
                            truth.height() + 2 * kMarginCells, kResolution_m,
                            {.translation = {-kMarginCells * kResolution_m,
                                             -kMarginCells * kResolution_m}},
                            Occupancy::kUnknown);
  Votes votes(map.cells.size());
  const std::vector<Float3> directions = AllAround();
  std::vector<RayHit> hits(directions.size());
  for (int y = kEveryCells / 2; y < truth.height(); y += kEveryCells) {
    for (int x = kEveryCells / 2; x < truth.width(); x += kEveryCells) {
      const GroundCell& cell =
          level.cells[static_cast<size_t>(y * truth.width() + x)];
      if (cell.state != GroundState::kFree) continue;
      const Vec2 from = map.CenterInMap({x + kMarginCells, y + kMarginCells});
      snapshot.CastMany({static_cast<float>(from.x), static_cast<float>(from.y),
                         cell.height_m + static_cast<float>(laser_height_m)},
                        directions, hits);
      for (size_t i = 0; i < hits.size(); ++i) {
        const RayHit& hit = hits[i];
        if (hit.surface == RayHit::kNothing || hit.distance > kRange_m) {
          continue;
        }
        const bool is_upright =
            hit.instance != RayHit::kFixed ||
            std::abs(world.surfaces[hit.surface].Normal().z) < kLevelNormal;
        Vote(map, from, {directions[i].x, directions[i].y}, hit.distance,
             is_upright, votes);
      }
    }
  }
  OccupancyGrid opaque = map;
  for (size_t i = 0; i < map.cells.size(); ++i) {
    const int seen = votes.hits[i] + votes.passes[i];
    if (seen == 0) continue;
    map.cells[i] = votes.hits[i] >= kHitShare * seen ? Occupancy::kOccupied
                                                     : Occupancy::kFree;
    opaque.cells[i] = votes.hits[i] >= kOpaqueShare * seen
                          ? Occupancy::kOccupied
                          : Occupancy::kFree;
  }
  return {.map = std::move(map), .opaque = std::move(opaque)};
}

}  // namespace

absl::StatusOr<SuiteWorld> SuiteWorld::Create(const World& world,
                                              double laser_height_m) {
  TL_ASSIGN_OR_RETURN(
      GroundTruth truth,
      GroundTruth::Compute(
          world, {.resolution_m = kResolution_m, .max_slope_rad = 0.25}));
  TL_ASSIGN_OR_RETURN(const RayCaster caster, RayCaster::Create(world));
  const WorldSnapshot snapshot = caster.At(StandingBodies(world));
  SuiteWorld suite(std::move(truth));
  for (const GroundLevel& level : suite.truth_.levels()) {
    suite.laser_maps_.push_back(
        MapLevel(world, snapshot, suite.truth_, level, laser_height_m));
  }
  suite.FindPlaces(world);
  if (suite.places_.empty()) {
    return absl::FailedPreconditionError(
        "the world has no tour with room for the robot to begin at");
  }
  return suite;
}

void SuiteWorld::FindPlaces(const World& world) {
  for (const Float3& corner : world.tour) {
    const GroundTruth::Reach reach =
        truth_.ReachableFrom(corner, kRobotRadius_m);
    if (reach.count() == 0) continue;
    for (int level = 0; level < static_cast<int>(truth_.levels().size());
         ++level) {
      for (int y = 0; y < truth_.height(); ++y) {
        for (int x = 0; x < truth_.width(); ++x) {
          const GroundCellIndex index = {.level = level, .x = x, .y = y};
          if (reach.Contains(index)) places_.push_back(index);
        }
      }
    }
    return;
  }
}

std::optional<int> SuiteWorld::LevelAt(Vec3 position) const {
  const std::optional<GroundCellIndex> cell = truth_.Find(
      {static_cast<float>(position.x), static_cast<float>(position.y),
       static_cast<float>(position.z)});
  if (!cell.has_value()) return std::nullopt;
  return cell->level;
}

RobotPlacement SuiteWorld::AnyPlace(Random& random) const {
  const GroundCellIndex& cell =
      places_[random.NextBelow(static_cast<uint32_t>(places_.size()))];
  return {.position = {(cell.x + 0.5) * kResolution_m,
                       (cell.y + 0.5) * kResolution_m},
          .yaw_rad = random.NextUniform(-std::numbers::pi, std::numbers::pi),
          .height_m = truth_.at(cell).height_m};
}

}  // namespace treeline

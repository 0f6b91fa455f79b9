#include "simulation/runs/lost_suite_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/renderer/ray_caster.h"

namespace treeline::runs {
namespace {

constexpr double kResolution_m = 0.05;
// From so far apart places, in so many directions, rays are cast; from farther
// apart ones in a large hall, which are so many at the most.
constexpr int kEveryCells = 7;
constexpr double kMaxPlaces = 5000;
constexpr int kDirections = 720;
constexpr double kRange_m = 30;
constexpr double kHitShare = 0.25;
constexpr double kOpaqueShare = 0.75;
// Walls lie on the edges of the ground.
constexpr int kMarginCells = 10;
// What is this near the vertical is ground or the top of something.
constexpr float kLevelNormal = 0.5f;
constexpr double kRobotRadius_m = 0.45;
// What is near to be carried to.
constexpr double kNear_m = 2;
// Obstacles stand so far from the tour's line.
constexpr double kObstacleFrom_m = 1.0;
constexpr double kObstacleTo_m = 2.5;

// How often rays ended in a cell, and how often they went through.
struct Votes {
  explicit Votes(size_t cells) : hits(cells), passes(cells) {}
  std::vector<int> hits;
  std::vector<int> passes;
};

std::vector<worlds::BodyInstance> StandingBodies(const worlds::World& world) {
  std::vector<worlds::BodyInstance> standing;
  for (const worlds::BodyInstance& instance : world.InstancesAt(0)) {
    const worlds::Body& body = world.bodies[static_cast<size_t>(instance.body)];
    const std::vector<worlds::Motion::Key>& keys = body.motion->keys;
    if (std::ranges::all_of(keys, [&keys](const worlds::Motion::Key& key) {
          return key.world_from_body.origin == keys[0].world_from_body.origin;
        })) {
      standing.push_back(instance);
    }
  }
  return standing;
}

// The end of one ray is noted, and all that it went through, at steps of half a
// cell.
void Vote(const core::OccupancyGrid& map, geometry::Vec2 from,
          geometry::Vec2 direction, double range_m, bool ends_there,
          Votes& votes) {
  const geometry::Rigid2 grid_from_map = map.map_from_grid.Inverse();
  const geometry::Vec2 first = (1 / map.resolution_m) * (grid_from_map * from);
  const geometry::Rigid2 turn = {.translation = {},
                                 .yaw_rad = grid_from_map.yaw_rad};
  const geometry::Vec2 half_step = 0.5 * (turn * direction);
  const auto cell_at = [&](double half_steps) -> core::CellIndex {
    return {static_cast<int>(std::floor(first.x + half_steps * half_step.x)),
            static_cast<int>(std::floor(first.y + half_steps * half_step.y))};
  };
  const double half_steps = 2 * range_m / map.resolution_m;
  core::CellIndex last = {-1, -1};
  for (int i = 0; i < half_steps - 1; ++i) {
    const core::CellIndex cell = cell_at(i);
    if (cell == last || !map.Contains(cell)) continue;
    ++votes.passes[map.IndexOf(cell)];
    last = cell;
  }
  if (!ends_there) return;
  const core::CellIndex end = map.CellOf(from + (range_m + 0.01) * direction);
  if (map.Contains(end)) ++votes.hits[map.IndexOf(end)];
}

std::vector<worlds::Float3> AllAround() {
  std::vector<worlds::Float3> directions;
  for (int i = 0; i < kDirections; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kDirections;
    directions.push_back({static_cast<float>(std::cos(angle_rad)),
                          static_cast<float>(std::sin(angle_rad)), 0});
  }
  return directions;
}

localization::LaserMap MapLevel(const worlds::World& world,
                                const renderer::WorldSnapshot& snapshot,
                                const worlds::GroundTruth& truth,
                                const worlds::GroundLevel& level,
                                double laser_height_m) {
  core::OccupancyGrid map = core::OccupancyGrid::Filled(
      truth.width() + 2 * kMarginCells, truth.height() + 2 * kMarginCells,
      kResolution_m,
      {.translation = {-kMarginCells * kResolution_m,
                       -kMarginCells * kResolution_m}},
      core::Occupancy::kUnknown);
  Votes votes(map.cells.size());
  const std::vector<worlds::Float3> directions = AllAround();
  std::vector<renderer::RayHit> hits(directions.size());
  const int every = std::max(
      kEveryCells,
      static_cast<int>(std::ceil(std::sqrt(static_cast<double>(truth.width()) *
                                           truth.height() / kMaxPlaces))));
  for (int y = every / 2; y < truth.height(); y += every) {
    for (int x = every / 2; x < truth.width(); x += every) {
      const worlds::GroundCell& cell =
          level.cells[static_cast<size_t>(y * truth.width() + x)];
      if (cell.state != worlds::GroundState::kFree) continue;
      const geometry::Vec2 from =
          map.CenterInMap({x + kMarginCells, y + kMarginCells});
      snapshot.CastMany({static_cast<float>(from.x), static_cast<float>(from.y),
                         cell.height_m + static_cast<float>(laser_height_m)},
                        directions, hits);
      for (size_t i = 0; i < hits.size(); ++i) {
        const renderer::RayHit& hit = hits[i];
        if (hit.surface == renderer::RayHit::kNothing ||
            hit.distance > kRange_m) {
          continue;
        }
        const bool is_upright =
            hit.instance != renderer::RayHit::kFixed ||
            std::abs(world.surfaces[hit.surface].Normal().z) < kLevelNormal;
        Vote(map, from, {directions[i].x, directions[i].y}, hit.distance,
             is_upright, votes);
      }
    }
  }
  core::OccupancyGrid opaque = map;
  for (size_t i = 0; i < map.cells.size(); ++i) {
    const int seen = votes.hits[i] + votes.passes[i];
    if (seen == 0) continue;
    map.cells[i] = votes.hits[i] >= kHitShare * seen
                       ? core::Occupancy::kOccupied
                       : core::Occupancy::kFree;
    opaque.cells[i] = votes.hits[i] >= kOpaqueShare * seen
                          ? core::Occupancy::kOccupied
                          : core::Occupancy::kFree;
  }
  return {.map = std::move(map), .opaque = std::move(opaque)};
}

double DistanceToTour_m(const worlds::World& world,
                        const simulator::RobotPlacement& place) {
  double nearest_m = 1e9;
  for (size_t i = 0; i < world.tour.size(); ++i) {
    const worlds::Float3 a = world.tour[i];
    const worlds::Float3 b = world.tour[(i + 1) % world.tour.size()];
    if (std::max(std::abs(a.z - place.height_m),
                 std::abs(b.z - place.height_m)) > 1.5) {
      continue;
    }
    const geometry::Vec2 from{a.x, a.y};
    const geometry::Vec2 way = geometry::Vec2{b.x, b.y} - from;
    const double along = std::clamp(
        Dot(place.position - from, way) / (Dot(way, way) + 1e-9), 0.0, 1.0);
    nearest_m = std::min(nearest_m, Norm(place.position - from - along * way));
  }
  return nearest_m;
}

}  // namespace

absl::StatusOr<SuiteWorld> SuiteWorld::Create(const worlds::World& world,
                                              double laser_height_m) {
  TL_ASSIGN_OR_RETURN(
      worlds::GroundTruth truth,
      worlds::GroundTruth::Compute(
          world, {.resolution_m = kResolution_m, .max_slope_rad = 0.25}));
  TL_ASSIGN_OR_RETURN(const renderer::RayCaster caster,
                      renderer::RayCaster::Create(world));
  const renderer::WorldSnapshot snapshot = caster.At(StandingBodies(world));
  SuiteWorld suite(std::move(truth));
  for (const worlds::GroundLevel& level : suite.truth_.levels()) {
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

void SuiteWorld::FindPlaces(const worlds::World& world) {
  for (const worlds::Float3& corner : world.tour) {
    const worlds::GroundTruth::Reach reach =
        truth_.ReachableFrom(corner, kRobotRadius_m);
    if (reach.count() == 0) continue;
    for (int level = 0; level < static_cast<int>(truth_.levels().size());
         ++level) {
      for (int y = 0; y < truth_.height(); ++y) {
        for (int x = 0; x < truth_.width(); ++x) {
          const worlds::GroundCellIndex index = {
              .level = level, .x = x, .y = y};
          if (reach.Contains(index)) places_.push_back(index);
        }
      }
    }
    return;
  }
}

std::optional<int> SuiteWorld::LevelAt(geometry::Vec3 position) const {
  const std::optional<worlds::GroundCellIndex> cell = truth_.Find(
      {static_cast<float>(position.x), static_cast<float>(position.y),
       static_cast<float>(position.z)});
  if (!cell.has_value()) return std::nullopt;
  return cell->level;
}

simulator::RobotPlacement SuiteWorld::AnyPlace(base::Random& random) const {
  const worlds::GroundCellIndex& cell =
      places_[random.NextBelow(static_cast<uint32_t>(places_.size()))];
  return {.position = {(cell.x + 0.5) * kResolution_m,
                       (cell.y + 0.5) * kResolution_m},
          .yaw_rad = random.NextUniform(-std::numbers::pi, std::numbers::pi),
          .height_m = truth_.at(cell).height_m};
}

int AddObstacles(const SuiteWorld& map, int count, uint64_t seed,
                 simulator::Simulator& simulator) {
  base::Random random(seed, 99);
  int added = 0;
  for (int i = 0; i < 60 * count && added < count; ++i) {
    const simulator::RobotPlacement place = map.AnyPlace(random);
    const double away_m = DistanceToTour_m(simulator.world(), place);
    const worlds::Float3 scale = {
        static_cast<float>(random.NextUniform(0.3, 0.8)),
        static_cast<float>(random.NextUniform(0.3, 0.8)),
        static_cast<float>(random.NextUniform(0.5, 1.4))};
    if (away_m < kObstacleFrom_m || away_m > kObstacleTo_m) continue;
    if (simulator
            .AddObstacle(absl::StrCat("new-", added), "crate", place, scale)
            .ok()) {
      ++added;
    }
  }
  return added;
}

absl::Status CarryAway(const SuiteWorld& map, bool near, base::Random& random,
                       simulator::Simulator& simulator) {
  const geometry::Rigid3 before = simulator.state().world_from_base;
  const geometry::Vec2 here = {before.translation.x, before.translation.y};
  absl::Status status =
      absl::NotFoundError("there is no room to be carried to");
  for (int i = 0; i < 2000; ++i) {
    const simulator::RobotPlacement place = map.AnyPlace(random);
    if (near && (Norm(place.position - here) > kNear_m ||
                 std::abs(place.height_m - before.translation.z) > 1)) {
      continue;
    }
    status = simulator.Kidnap(place);
    if (status.ok()) break;
  }
  return status;
}

}  // namespace treeline::runs

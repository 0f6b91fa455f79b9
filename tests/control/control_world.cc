#include "tests/control/control_world.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "tests/traversable_worlds/testing_world.h"

namespace treeline {
namespace {

constexpr double kSameGround_m = 0.08;
// Keep-outs do not count so near to the start: the robot is there (m).
constexpr double kLeave_m = 0.6;

std::shared_ptr<const traversability::NavigationMap> MapOf(
    const worlds::World& world) {
  auto levels = traversability::ExtractTraversableMap(
      VoxelizeWorld(world),
      traversability::TraversabilityOptions::For(core::RobotModel()));
  return std::make_shared<const traversability::NavigationMap>(
      *traversability::NavigationMap::Make(*std::move(levels)));
}

}  // namespace

ControlWorld::ControlWorld(const std::string& name, bool with_people)
    : ControlWorld(*worlds::MakeWorld(
          name, {.with_people = with_people, .paint = false})) {}

ControlWorld::ControlWorld(worlds::World world)
    : world_(std::move(world)), map_(MapOf(world_)) {}

core::LevelPose ControlWorld::PlaceAt(geometry::Vec2 at, double yaw_rad,
                                      double world_height_m) const {
  core::LevelPose pose = {
      .map_from_base = {.translation = at, .yaw_rad = yaw_rad},
      .place = {.level = 0, .height_m = world_height_m + kMapLift_m}};
  const auto ground = map_->GroundNear(at, pose.place.height_m);
  if (ground.has_value()) pose.place = *ground;
  return pose;
}

core::LevelPose ControlWorld::AnyPlace(base::Random& random,
                                       double clearance_m) const {
  for (;;) {
    const int level = static_cast<int>(
        random.NextBelow(static_cast<uint32_t>(map_->levels())));
    const core::OccupancyGrid& grid = map_->grid(level);
    const core::CellIndex cell = {
        static_cast<int>(random.NextBelow(static_cast<uint32_t>(grid.width))),
        static_cast<int>(random.NextBelow(static_cast<uint32_t>(grid.height)))};
    const double yaw_rad =
        random.NextUniform(-std::numbers::pi, std::numbers::pi);
    if (!map_->IsFree(level, cell) ||
        map_->ClearanceAt_m(level, cell) < clearance_m) {
      continue;
    }
    const geometry::Vec2 at = grid.CenterInMap(cell);
    return {.map_from_base = {.translation = at, .yaw_rad = yaw_rad},
            .place = *map_->GroundOf(at, level)};
  }
}

bool ControlWorld::IsOpen(int level, core::CellIndex cell, double clearance_m,
                          const std::vector<KeepOut>& keep_out) const {
  if (!map_->IsFree(level, cell) ||
      map_->ClearanceAt_m(level, cell) < clearance_m) {
    return false;
  }
  const geometry::Vec2 at = map_->grid(level).CenterInMap(cell);
  return std::ranges::none_of(keep_out, [&](const KeepOut& disc) {
    return Norm(disc.center - at) < disc.radius_m + clearance_m;
  });
}

bool ControlWorld::SeesStraight(const core::LevelPose& a,
                                const core::LevelPose& b, double clearance_m,
                                const std::vector<KeepOut>& keep_out) const {
  const geometry::Vec2 from = a.map_from_base.translation;
  const geometry::Vec2 way = b.map_from_base.translation - from;
  const int steps = static_cast<int>(Norm(way) / 0.03) + 1;
  double height_m = a.place.height_m;
  for (int i = 0; i <= steps; ++i) {
    const geometry::Vec2 at = from + (static_cast<double>(i) / steps) * way;
    const auto ground = map_->GroundNear(at, height_m);
    if (!ground.has_value() ||
        std::abs(ground->height_m - height_m) > kSameGround_m ||
        !IsOpen(ground->level, map_->grid(0).CellOf(at), clearance_m,
                keep_out)) {
      return false;
    }
    height_m = ground->height_m;
  }
  return std::abs(height_m - b.place.height_m) < kSameGround_m;
}

std::vector<core::LevelPose> ControlWorld::FindPath(
    const core::LevelPose& start, const core::LevelPose& goal,
    double clearance_m, const std::vector<KeepOut>& keep_out) const {
  const core::OccupancyGrid& grid = map_->grid(0);
  const size_t per_level = grid.cells.size();
  const size_t nodes = per_level * static_cast<size_t>(map_->levels());
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<double> cost(nodes, kFar);
  std::vector<size_t> parent(nodes, nodes);
  const auto node_of = [&](const core::LevelPose& pose) {
    return static_cast<size_t>(pose.place.level) * per_level +
           grid.IndexOf(grid.CellOf(pose.map_from_base.translation));
  };
  const auto height_of = [&](size_t node) {
    return map_->traversable()
        .levels[node / per_level]
        .height_m[node % per_level];
  };
  using Entry = std::pair<double, size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const size_t first = node_of(start);
  const size_t last = node_of(goal);
  cost[first] = 0;
  open.push({0, first});
  const int width = grid.width;
  while (!open.empty()) {
    const auto [so_far, node] = open.top();
    open.pop();
    if (so_far > cost[node]) continue;
    if (node == last) break;
    const int cell = static_cast<int>(node % per_level);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const core::CellIndex to = {cell % width + dx, cell / width + dy};
        if (!grid.Contains(to)) continue;
        for (int level = 0; level < map_->levels(); ++level) {
          const size_t next =
              static_cast<size_t>(level) * per_level + grid.IndexOf(to);
          const double price = so_far + std::hypot(dx, dy) + 0.01;
          if (next == node || price >= cost[next] ||
              !(std::abs(height_of(next) - height_of(node)) < kSameGround_m) ||
              (next != last &&
               !IsOpen(level, to, clearance_m,
                       Norm(grid.CenterInMap(to) -
                            start.map_from_base.translation) < kLeave_m
                           ? std::vector<KeepOut>()
                           : keep_out))) {
            continue;
          }
          cost[next] = price;
          parent[next] = node;
          open.push({price, next});
        }
      }
    }
  }
  if (cost[last] == kFar) return {};
  std::vector<core::LevelPose> cells = {goal};
  for (size_t node = parent[last]; node < nodes; node = parent[node]) {
    const int cell = static_cast<int>(node % per_level);
    const geometry::Vec2 at = grid.CenterInMap({cell % width, cell / width});
    const int level = static_cast<int>(node / per_level);
    cells.push_back({.map_from_base = {.translation = at, .yaw_rad = 0},
                     .place = *map_->GroundOf(at, level)});
  }
  cells.back().map_from_base = start.map_from_base;
  std::ranges::reverse(cells);
  std::vector<core::LevelPose> path = {cells[0]};
  for (size_t at = 0; at + 1 < cells.size();) {
    size_t next = at + 1;
    for (size_t far = std::min(cells.size() - 1, at + 200); far > next;
         far = far - 1 - (far - next) / 12) {
      if (SeesStraight(cells[at], cells[far], clearance_m, keep_out)) {
        next = far;
        break;
      }
    }
    core::LevelPose pose = cells[next];
    const geometry::Vec2 way =
        pose.map_from_base.translation - path.back().map_from_base.translation;
    if (next + 1 < cells.size()) {
      pose.map_from_base.yaw_rad = std::atan2(way.y, way.x);
    }
    path.push_back(pose);
    at = next;
  }
  return path;
}

}  // namespace treeline

#include "nav_agent/planning/routes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "nav_agent/planning/open_nodes.h"

namespace treeline::planning {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
constexpr std::array<core::CellIndex, 8> kBeside = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

Spot SpotOfCell(const GroundIndex& ground, uint32_t number) {
  const auto cell = static_cast<int>(number % ground.cells());
  return {.at = ground.CenterOf({cell % ground.width(), cell / ground.width()}),
          .level = static_cast<int>(number / ground.cells())};
}

// Dijkstra within one region, which has 64 cells at most.
class WithinRegion {
 public:
  WithinRegion(const ConfigurationSpace& space, const Regions& regions)
      : space_(&space), regions_(&regions) {}

  // Appends the cells after `from` up to `to`, of the same region.
  void AddWay(uint32_t from, uint32_t to, Polyline& way) const {
    if (from == to) return;
    const GroundIndex& ground = space_->ground();
    if (IsStraight(from, to)) {
      way.push_back(SpotOfCell(ground, to));
      return;
    }
    // From the far end: the parents lead to `to`.
    std::array<float, kCells> cost_m{};
    cost_m.fill(kFar);
    std::array<uint32_t, kCells> parent{};
    OpenNodes open;
    cost_m[InBlock(to)] = 0;
    parent[InBlock(to)] = to;
    open.push({0, to});
    while (!open.empty()) {
      const OpenNode next = open.top();
      open.pop();
      if (next.number == from) break;
      const float own_m = cost_m[InBlock(next.number)];
      if (next.estimate_m > own_m) continue;
      const Spot spot = SpotOfCell(ground, next.number);
      const core::CellIndex cell = ground.CellOf(spot.at);
      for (const core::CellIndex& step : kBeside) {
        const core::CellIndex beside = {cell.x + step.x, cell.y + step.y};
        if (!ground.Contains(beside)) continue;
        const auto number = static_cast<uint32_t>(
            static_cast<size_t>(spot.level) * ground.cells() +
            ground.IndexOf(beside));
        if (regions_->RegionOfCell(number) != regions_->RegionOfCell(to)) {
          continue;
        }
        const double step_m =
            ground.resolution_m() *
            (step.x != 0 && step.y != 0 ? std::numbers::sqrt2 : 1.0);
        const auto cost =
            own_m + static_cast<float>(step_m * space_->CostPerMetre(SpotOfCell(
                                                    ground, number)));
        if (cost >= cost_m[InBlock(number)]) continue;
        cost_m[InBlock(number)] = cost;
        parent[InBlock(number)] = next.number;
        open.push({cost, number});
      }
    }
    if (!std::isfinite(cost_m[InBlock(from)])) return;
    for (uint32_t at = from; at != to;) {
      at = parent[InBlock(at)];
      way.push_back(SpotOfCell(ground, at));
    }
  }

 private:
  static constexpr size_t kCells =
      size_t{Regions::kBlockCells} * Regions::kBlockCells;

  size_t InBlock(uint32_t number) const {
    const GroundIndex& ground = space_->ground();
    const auto cell = static_cast<int>(number % ground.cells());
    return static_cast<size_t>(cell / ground.width() % Regions::kBlockCells *
                                   Regions::kBlockCells +
                               cell % ground.width() % Regions::kBlockCells);
  }

  // Whether all cells of the line are of the region.
  bool IsStraight(uint32_t from, uint32_t to) const {
    const GroundIndex& ground = space_->ground();
    const Spot begin = SpotOfCell(ground, from);
    const geometry::Vec2 line = SpotOfCell(ground, to).at - begin.at;
    const int steps =
        static_cast<int>(2 * geometry::Norm(line) / ground.resolution_m()) + 1;
    for (int i = 1; i < steps; ++i) {
      const Spot at = {begin.at + (static_cast<double>(i) / steps) * line,
                       begin.level};
      if (regions_->RegionOf(ground, at) != regions_->RegionOfCell(from)) {
        return false;
      }
    }
    return true;
  }

  const ConfigurationSpace* space_;
  const Regions* regions_;
};

}  // namespace

namespace {

Route RouteOver(const Regions& regions, uint32_t start, uint32_t goal,
                const std::vector<float>& weights, bool may_be_against) {
  std::vector<float> cost_m(regions.count(), kFar);
  std::vector<uint32_t> parent(regions.count(), kNone);
  std::vector<uint8_t> edge_of(regions.count());
  const auto estimate_m = [&](uint32_t region) {
    return static_cast<float>(geometry::Norm(regions.region(region).center -
                                             regions.region(goal).center));
  };
  OpenNodes open;
  cost_m[start] = 0;
  open.push({estimate_m(start), start});
  while (!open.empty()) {
    const OpenNode next = open.top();
    open.pop();
    if (next.number == goal) break;
    const float own_m = cost_m[next.number];
    if (next.estimate_m > own_m + estimate_m(next.number)) continue;
    const std::span<const Regions::Edge> edges = regions.EdgesOf(next.number);
    for (size_t i = 0; i < edges.size(); ++i) {
      if (edges[i].is_against && !may_be_against) continue;
      const uint32_t to = edges[i].to;
      const float weight =
          weights.empty() ? 1 : (weights[next.number] + weights[to]) / 2;
      const float cost = own_m + weight * edges[i].cost_m;
      if (cost >= cost_m[to]) continue;
      cost_m[to] = cost;
      parent[to] = next.number;
      edge_of[to] = static_cast<uint8_t>(i);
      open.push({cost + estimate_m(to), to});
    }
  }
  Route route{.is_found = start == goal || parent[goal] != kNone,
              .cost_m = cost_m[goal],
              .edges = {}};
  if (!route.is_found) return route;
  for (uint32_t at = goal; at != start; at = parent[at]) {
    route.edges.push_back(regions.EdgesOf(parent[at])[edge_of[at]]);
  }
  std::ranges::reverse(route.edges);
  return route;
}

}  // namespace

Route FindRoute(const Regions& regions, uint32_t start, uint32_t goal,
                const std::vector<float>& weights) {
  Route route = RouteOver(regions, start, goal, weights, false);
  // Regions are coarse: the footprint may find a way where they see none.
  return route.is_found ? route
                        : RouteOver(regions, start, goal, weights, true);
}

RouteField::RouteField(const Regions& regions, uint32_t root, float reach_m,
                       float Regions::Edge::*price)
    : regions_(&regions),
      cost_m_(regions.count(), kFar),
      length_m_(regions.count(), kFar),
      next_(regions.count(), -1) {
  OpenNodes open;
  cost_m_[root] = 0;
  length_m_[root] = 0;
  open.push({0, root});
  while (!open.empty()) {
    const OpenNode next = open.top();
    open.pop();
    if (next.estimate_m > cost_m_[next.number]) continue;
    for (const Regions::Edge& edge : regions.EdgesOf(next.number)) {
      const float cost_m = next.estimate_m + edge.*price;
      if (cost_m >= cost_m_[edge.to] || cost_m > reach_m) continue;
      cost_m_[edge.to] = cost_m;
      length_m_[edge.to] = length_m_[next.number] + edge.length_m;
      const std::span<const Regions::Edge> back = regions.EdgesOf(edge.to);
      const auto way = std::ranges::find(back, next.number, &Regions::Edge::to);
      next_[edge.to] = static_cast<int32_t>(way - back.begin());
      open.push({cost_m, edge.to});
    }
  }
}

Route RouteField::RouteFrom(uint32_t region) const {
  Route route{.is_found = std::isfinite(cost_m_[region]),
              .cost_m = cost_m_[region],
              .edges = {}};
  if (!route.is_found) return route;
  for (uint32_t at = region; next_[at] >= 0;) {
    route.edges.push_back(
        regions_->EdgesOf(at)[static_cast<size_t>(next_[at])]);
    at = route.edges.back().to;
  }
  return route;
}

Route Reversed(const Regions& regions, const Route& route, uint32_t from) {
  Route back{.is_found = route.is_found, .cost_m = route.cost_m, .edges = {}};
  uint32_t at = from;
  for (const Regions::Edge& edge : route.edges) {
    const std::span<const Regions::Edge> edges = regions.EdgesOf(edge.to);
    back.edges.push_back(*std::ranges::find(edges, at, &Regions::Edge::to));
    at = edge.to;
  }
  std::ranges::reverse(back.edges);
  return back;
}

Polyline CellsAlong(const ConfigurationSpace& space, const Regions& regions,
                    const Spot& start, const Spot& goal, const Route& route) {
  const GroundIndex& ground = space.ground();
  const auto cell_of = [&ground](const Spot& spot) {
    return static_cast<uint32_t>(static_cast<size_t>(spot.level) *
                                     ground.cells() +
                                 ground.IndexOf(ground.CellOf(spot.at)));
  };
  const WithinRegion within(space, regions);
  Polyline way = {start};
  uint32_t at = cell_of(start);
  for (const Regions::Edge& edge : route.edges) {
    within.AddWay(at, edge.from_cell, way);
    way.push_back(SpotOfCell(ground, edge.to_cell));
    at = edge.to_cell;
  }
  within.AddWay(at, cell_of(goal), way);
  if (way.size() > 1 && cell_of(way.back()) == cell_of(goal)) way.pop_back();
  way.push_back(goal);
  return way;
}

DistanceToGoal::DistanceToGoal(const GroundIndex& ground,
                               const Regions& regions, const Spot& goal,
                               float reach_m)
    : ground_(&ground),
      regions_(&regions),
      goal_(goal),
      goal_region_(static_cast<uint32_t>(regions.RegionOf(ground, goal))),
      field_(regions, goal_region_, reach_m) {}

float DistanceToGoal::Of_m(const Spot& spot) const {
  const int number = regions_->RegionOf(*ground_, spot);
  if (number < 0) return kFar;
  const auto region = static_cast<uint32_t>(number);
  if (region == goal_region_) {
    return static_cast<float>(geometry::Norm(goal_.at - spot.at));
  }
  float best_m = kFar;
  for (const Regions::Edge& edge : regions_->EdgesOf(region)) {
    const geometry::Vec2 enters = SpotOfCell(*ground_, edge.to_cell).at;
    const double beyond_m =
        edge.to == goal_region_
            ? geometry::Norm(goal_.at - enters)
            : geometry::Norm(regions_->region(edge.to).center - enters) +
                  static_cast<double>(field_.length_m(edge.to));
    best_m = std::min(best_m, static_cast<float>(
                                  geometry::Norm(enters - spot.at) + beyond_m));
  }
  return best_m;
}

}  // namespace treeline::planning

#include "nav_agent/planning/alternatives.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

}  // namespace

Alternatives::Alternatives(const ConfigurationSpace& space,
                           const Regions& regions, const Spot& start,
                           const Spot& goal, double known_m)
    : space_(&space),
      regions_(&regions),
      start_(start),
      goal_(goal),
      start_region_(
          static_cast<uint32_t>(regions.RegionOf(space.ground(), start))),
      from_start_(regions, start_region_, kFar, &Regions::Edge::short_m),
      to_goal_(regions,
               static_cast<uint32_t>(regions.RegionOf(space.ground(), goal)),
               kFar, &Regions::Edge::short_m),
      is_covered_(regions.count(), false) {
  const auto max_cost_m = static_cast<float>(
      kAlternativeCost *
      (known_m + Regions::kBlockCells * space.ground().resolution_m()));
  for (uint32_t region = 0; region < regions.count(); ++region) {
    const float cost_m = from_start_.cost_m(region) + to_goal_.cost_m(region);
    if (cost_m <= max_cost_m) vias_.push_back({cost_m, region});
  }
  std::ranges::sort(vias_, [](const Via& a, const Via& b) {
    return a.cost_m != b.cost_m ? a.cost_m < b.cost_m : a.region < b.region;
  });
}

Polyline Alternatives::Next() {
  while (next_ < vias_.size() && is_covered_[vias_[next_].region]) ++next_;
  if (next_ == vias_.size()) return {};
  const uint32_t via = vias_[next_].region;
  Route route = Reversed(*regions_, from_start_.RouteFrom(via), via);
  const Route rest = to_goal_.RouteFrom(via);
  route.edges.insert(route.edges.end(), rest.edges.begin(), rest.edges.end());
  Cover(route);
  return CellsAlong(*space_, *regions_, start_, goal_, route);
}

bool Alternatives::Sees(uint32_t from, uint32_t to) const {
  const Regions::Region& a = regions_->region(from);
  const Regions::Region& b = regions_->region(to);
  const geometry::Vec2 line = b.center - a.center;
  const double length_m = geometry::Norm(line);
  if (length_m > kSight_m || a.level != b.level) return false;
  return length_m < 1e-6 ||
         space_->ground().IsFree(
             a.level, {.origin = a.center,
                       .cos_yaw = line.x / length_m,
                       .sin_yaw = line.y / length_m,
                       .back_m = 0,
                       .front_m = length_m,
                       .half_width_m = space_->ground().resolution_m() / 2});
}

void Alternatives::Cover(const Route& route) {
  struct Seen {
    uint32_t region = 0;
    uint32_t from = 0;
  };
  std::vector<Seen> seen;
  const auto add = [&](uint32_t region) {
    is_covered_[region] = true;
    seen.push_back({region, region});
  };
  add(start_region_);
  for (const Regions::Edge& edge : route.edges) add(edge.to);
  for (size_t i = 0; i < seen.size(); ++i) {
    for (const Regions::Edge& edge : regions_->EdgesOf(seen[i].region)) {
      if (is_covered_[edge.to] || !Sees(seen[i].from, edge.to)) continue;
      is_covered_[edge.to] = true;
      seen.push_back({edge.to, seen[i].from});
    }
  }
}

}  // namespace treeline::planning

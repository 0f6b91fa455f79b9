#include "nav_agent/behavior/obstacle_discs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

constexpr uint8_t kSeen = 2;

std::vector<geometry::Vec2> SeenNear(const control::CostmapView& costmap,
                                     geometry::Vec2 about, double reach_m) {
  std::vector<geometry::Vec2> points;
  for (int y = 0; y < costmap.height; ++y) {
    for (int x = 0; x < costmap.width; ++x) {
      const size_t index =
          static_cast<size_t>(y) * static_cast<size_t>(costmap.width) +
          static_cast<size_t>(x);
      if (costmap.cells[index] != kSeen) continue;
      const geometry::Vec2 point =
          costmap.origin_in_map +
          geometry::Vec2{(x + 0.5) * costmap.resolution_m,
                         (y + 0.5) * costmap.resolution_m};
      if (geometry::Norm(point - about) <= reach_m) points.push_back(point);
    }
  }
  return points;
}

}  // namespace

std::vector<planning::Blockage> DiscsOf(const control::CostmapView& costmap,
                                        geometry::Vec2 about,
                                        geometry::Vec2 eye, double radius_m,
                                        double fallback_radius_m, int level) {
  std::vector<geometry::Vec2> seen = SeenNear(costmap, about, kObstacleReach_m);
  // Nearest first: what hangs together grows from there.
  std::ranges::sort(seen, [about](geometry::Vec2 a, geometry::Vec2 b) {
    return geometry::Norm(a - about) < geometry::Norm(b - about);
  });
  std::vector<geometry::Vec2> centers;
  for (const geometry::Vec2 point : seen) {
    double nearest_m =
        geometry::Norm(point - about) <= kObstacleNear_m && centers.empty()
            ? kDiscSpacing_m
            : kObstacleReach_m;
    for (const geometry::Vec2 center : centers) {
      nearest_m = std::min(nearest_m, geometry::Norm(point - center));
    }
    if (nearest_m >= kDiscSpacing_m && nearest_m <= kObstacleGap_m) {
      centers.push_back(point);
    }
  }
  if (centers.empty()) {
    return {{.center = about, .radius_m = fallback_radius_m, .level = level}};
  }
  std::vector<planning::Blockage> discs;
  for (const geometry::Vec2 center : centers) {
    discs.push_back({.center = center, .radius_m = radius_m, .level = level});
    const geometry::Vec2 way = center - eye;
    const double way_m = geometry::Norm(way);
    if (way_m < kDiscSpacing_m) continue;
    discs.push_back({.center = center + (kDiscSpacing_m / way_m) * way,
                     .radius_m = radius_m,
                     .level = level});
  }
  return discs;
}

bool IsSeenNear(const control::CostmapView& costmap, geometry::Vec2 about,
                double reach_m) {
  return !SeenNear(costmap, about, reach_m).empty();
}

}  // namespace treeline::behavior

#include "nav_agent/behavior/obstacle_discs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::behavior {
namespace {

constexpr uint8_t kSeen = 2;
// The first seen cell is this near to where the band broke, and no other is
// further away than that.
constexpr double kNear_m = 0.6;
constexpr double kFar_m = 1.6;
// Parts with less between them belong together: the robot is wider.
constexpr double kGap_m = 0.55;
constexpr double kSpacing_m = 0.2;
constexpr double kBehind_m = 0.2;

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
  std::vector<geometry::Vec2> seen = SeenNear(costmap, about, kFar_m);
  // Nearest first: what hangs together grows from there.
  std::ranges::sort(seen, [about](geometry::Vec2 a, geometry::Vec2 b) {
    return geometry::Norm(a - about) < geometry::Norm(b - about);
  });
  std::vector<geometry::Vec2> centers;
  for (const geometry::Vec2 point : seen) {
    double nearest_m =
        geometry::Norm(point - about) <= kNear_m && centers.empty() ? kSpacing_m
                                                                    : kFar_m;
    for (const geometry::Vec2 center : centers) {
      nearest_m = std::min(nearest_m, geometry::Norm(point - center));
    }
    if (nearest_m >= kSpacing_m && nearest_m <= kGap_m) {
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
    if (way_m < kBehind_m) continue;
    discs.push_back({.center = center + (kBehind_m / way_m) * way,
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

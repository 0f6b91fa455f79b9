#include "nav_agent/behavior/obstacle_discs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline {
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

std::vector<Vec2> SeenNear(const CostmapView& costmap, Vec2 about,
                           double reach_m) {
  std::vector<Vec2> points;
  for (int y = 0; y < costmap.height; ++y) {
    for (int x = 0; x < costmap.width; ++x) {
      const size_t index =
          static_cast<size_t>(y) * static_cast<size_t>(costmap.width) +
          static_cast<size_t>(x);
      if (costmap.cells[index] != kSeen) continue;
      const Vec2 point =
          costmap.origin_in_map + Vec2{(x + 0.5) * costmap.resolution_m,
                                       (y + 0.5) * costmap.resolution_m};
      if (Norm(point - about) <= reach_m) points.push_back(point);
    }
  }
  return points;
}

}  // namespace

std::vector<Blockage> DiscsOf(const CostmapView& costmap, Vec2 about, Vec2 eye,
                              double radius_m, double fallback_radius_m,
                              int level) {
  std::vector<Vec2> seen = SeenNear(costmap, about, kFar_m);
  // Nearest first: what hangs together grows from there.
  std::ranges::sort(seen, [about](Vec2 a, Vec2 b) {
    return Norm(a - about) < Norm(b - about);
  });
  std::vector<Vec2> centers;
  for (const Vec2 point : seen) {
    double nearest_m =
        Norm(point - about) <= kNear_m && centers.empty() ? kSpacing_m : kFar_m;
    for (const Vec2 center : centers) {
      nearest_m = std::min(nearest_m, Norm(point - center));
    }
    if (nearest_m >= kSpacing_m && nearest_m <= kGap_m) {
      centers.push_back(point);
    }
  }
  if (centers.empty()) {
    return {{.center = about, .radius_m = fallback_radius_m, .level = level}};
  }
  std::vector<Blockage> discs;
  for (const Vec2 center : centers) {
    discs.push_back({.center = center, .radius_m = radius_m, .level = level});
    const Vec2 way = center - eye;
    const double way_m = Norm(way);
    if (way_m < kBehind_m) continue;
    discs.push_back({.center = center + (kBehind_m / way_m) * way,
                     .radius_m = radius_m,
                     .level = level});
  }
  return discs;
}

bool IsSeenNear(const CostmapView& costmap, Vec2 about, double reach_m) {
  return !SeenNear(costmap, about, reach_m).empty();
}

}  // namespace treeline

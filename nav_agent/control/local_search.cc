#include "nav_agent/control/local_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace treeline::control {

LocalWay FindLocalWay(const LocalCostmap& costmap, geometry::Vec2 start,
                      std::span<const geometry::Vec2> ends,
                      std::span<const double> end_costs_m,
                      const LocalSearchOptions& options) {
  LocalWay way;
  const CostmapWindow& window = costmap.window();
  const double r = window.resolution_m();
  const int width = window.width();
  const int height = window.height();
  const auto [start_x, start_y] = window.CellOf(start);
  if (!window.IsInside(start_x, start_y)) return way;
  const auto index = [&window](int x, int y) { return window.IndexOf(x, y); };
  const std::vector<float>& distances = costmap.distances_m();
  const double at_start_m = distances[index(start_x, start_y)];
  const int margin = static_cast<int>(options.inset_m / r);

  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<double> cost(distances.size(), kFar);
  std::vector<int> parent(distances.size(), -1);
  using Entry = std::pair<double, size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost[index(start_x, start_y)] = 0;
  open.push({0, index(start_x, start_y)});
  while (!open.empty()) {
    const auto [so_far, at] = open.top();
    open.pop();
    if (so_far > cost[at]) continue;
    const int at_x = static_cast<int>(at) % width;
    const int at_y = static_cast<int>(at) / width;
    for (int y = at_y - 1; y <= at_y + 1; ++y) {
      for (int x = at_x - 1; x <= at_x + 1; ++x) {
        if (x < margin || y < margin || x >= width - margin ||
            y >= height - margin) {
          continue;
        }
        const size_t next = index(x, y);
        const double room_m = distances[next];
        const double from_start_m = r * std::hypot(x - start_x, y - start_y);
        const double needed_m = from_start_m < kLeaving_m
                                    ? std::min(options.clearance_m, at_start_m)
                                    : options.clearance_m;
        if (room_m < needed_m || room_m <= 0) continue;
        const double lack =
            std::max(0.0, 1 - room_m / std::max(1e-6, options.desired_m));
        const double price = so_far + r * std::hypot(x - at_x, y - at_y) *
                                          (1 + options.price * lack * lack);
        if (price >= cost[next]) continue;
        cost[next] = price;
        parent[next] = static_cast<int>(at);
        open.push({price, next});
      }
    }
  }
  double best = kFar;
  size_t last = 0;
  for (size_t i = 0; i < ends.size(); ++i) {
    const auto [x, y] = window.CellOf(ends[i]);
    if (!window.IsInside(x, y)) continue;
    const double total = cost[index(x, y)] + end_costs_m[i];
    if (total >= best) continue;
    best = total;
    last = index(x, y);
    way.end = i;
  }
  if (best == kFar) return way;
  for (int at = static_cast<int>(last); at >= 0;
       at = parent[static_cast<size_t>(at)]) {
    way.points_in_map.push_back(window.CenterInMap(at % width, at / width));
  }
  std::ranges::reverse(way.points_in_map);
  way.points_in_map.front() = start;
  return way;
}

}  // namespace treeline::control

#include "nav_agent/control/local_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace treeline::control {
namespace {

// About the start cells are open that are no narrower than the start (m).
constexpr double kStartReach_m = 0.4;

}  // namespace

LocalWay FindLocalWay(const LocalCostmap& costmap, geometry::Vec2 start,
                      std::span<const geometry::Vec2> ends,
                      std::span<const double> end_costs_m,
                      const LocalSearchOptions& options) {
  LocalWay way;
  const double r = costmap.resolution_m();
  const int width = costmap.width();
  const int height = costmap.height();
  const geometry::Vec2 origin = costmap.origin_in_map();
  const auto cell_of = [&](geometry::Vec2 point) {
    return std::pair<int, int>{
        static_cast<int>(std::floor((point.x - origin.x) / r)),
        static_cast<int>(std::floor((point.y - origin.y) / r))};
  };
  const auto [start_x, start_y] = cell_of(start);
  if (start_x < 0 || start_y < 0 || start_x >= width || start_y >= height) {
    return way;
  }
  const auto index = [width](int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(width) +
           static_cast<size_t>(x);
  };
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
        const double needed_m = from_start_m < kStartReach_m
                                    ? std::min(options.clearance_m, at_start_m)
                                    : options.clearance_m;
        if (room_m < needed_m || room_m <= 0) continue;
        const double lack =
            std::max(0.0, 1 - room_m / std::max(1e-6, options.wished_m));
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
    const auto [x, y] = cell_of(ends[i]);
    if (x < 0 || y < 0 || x >= width || y >= height) continue;
    const double total = cost[index(x, y)] + end_costs_m[i];
    if (total >= best) continue;
    best = total;
    last = index(x, y);
    way.end = i;
  }
  if (best == kFar) return way;
  for (int at = static_cast<int>(last); at >= 0;
       at = parent[static_cast<size_t>(at)]) {
    way.points_in_map.push_back(costmap.CenterInMap(at % width, at / width));
  }
  std::ranges::reverse(way.points_in_map);
  way.points_in_map.front() = start;
  return way;
}

}  // namespace treeline::control

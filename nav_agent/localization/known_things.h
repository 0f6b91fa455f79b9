// What lasers see and the map does not have, and is known to be there.
#ifndef NAV_AGENT_LOCALIZATION_KNOWN_THINGS_H_
#define NAV_AGENT_LOCALIZATION_KNOWN_THINGS_H_

#include <cmath>
#include <set>
#include <span>
#include <tuple>

#include "common/geometry/rigid2.h"

namespace treeline::localization {

// Points at which beams have ended, by level.
class KnownThings {
 public:
  // What a beam may end beside such a point (m): twice this at most, this at
  // least. Estimates are not much more exact.
  static constexpr double kCell_m = 0.06;

  // In the map (m).
  void Add(int level, std::span<const geometry::Vec2> points_in_map) {
    for (const geometry::Vec2& point : points_in_map) {
      cells_.insert({level, CellOf(point.x), CellOf(point.y)});
    }
  }
  bool IsNear(int level, geometry::Vec2 point_in_map) const {
    const int x = CellOf(point_in_map.x);
    const int y = CellOf(point_in_map.y);
    for (int i = 0; i < 9; ++i) {
      if (cells_.contains({level, x + i % 3 - 1, y + i / 3 - 1})) return true;
    }
    return false;
  }
  bool empty() const { return cells_.empty(); }

 private:
  // Maps end before 1e6 m.
  static int CellOf(double at_m) {
    return static_cast<int>(std::floor(at_m / kCell_m));
  }

  std::set<std::tuple<int, int, int>> cells_;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_KNOWN_THINGS_H_

#include "nav_agent/behavior/seen_through.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

// The map's cells within kGhostReach_m of a place, and what is said of them.
class Patch {
 public:
  Patch(const traversability::NavigationMap& map, int level,
        geometry::Vec2 middle)
      : map_(map),
        level_(level),
        middle_(middle),
        reach_(static_cast<int>(std::ceil(kGhostReach_m / map.resolution_m()))),
        side_(2 * reach_ + 1),
        corner_(map.grid(level).CellOf(middle)),
        marks_(static_cast<size_t>(side_) * static_cast<size_t>(side_),
               Mark::kNone) {
    corner_.x -= reach_;
    corner_.y -= reach_;
  }

  // Marks what is not free within a distance of the middle, and what hangs
  // together with it. False if that reaches the patch's border.
  bool MarkObstacles(double within_m) {
    std::vector<core::CellIndex> open;
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) {
        const core::CellIndex cell{corner_.x + x, corner_.y + y};
        if (FromMiddle_m(cell) < within_m) Reach(cell, open);
      }
    }
    while (!open.empty()) {
      const core::CellIndex cell = open.back();
      open.pop_back();
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const core::CellIndex next{cell.x + dx, cell.y + dy};
          if (FromMiddle_m(next) > kGhostReach_m || !IndexOf(next)) {
            return false;
          }
          Reach(next, open);
        }
      }
    }
    return true;
  }

  // A beam: what it passes, up to two cells before its end, and what it ends
  // on.
  void Pass(geometry::Vec2 from, geometry::Vec2 to) {
    const double cell_m = map_.resolution_m();
    const double length_m = geometry::Norm(to - from);
    const core::CellIndex end = map_.grid(level_).CellOf(to);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        Set({end.x + dx, end.y + dy}, Mark::kHit);
      }
    }
    const double passed_m =
        std::min(length_m - 2 * cell_m, 2 * double{kGhostReach_m});
    for (double at_m = 0; at_m < passed_m; at_m += 0.5 * cell_m) {
      const geometry::Vec2 at = from + (at_m / length_m) * (to - from);
      Set(map_.grid(level_).CellOf(at), Mark::kPassed);
    }
  }

  // Of obstacles, no nearer to the middle than beside_m.
  int CountPassed(double beside_m) const {
    return Count(Mark::kPassed, beside_m);
  }
  int CountHit() const { return Count(Mark::kHit, 0); }

 private:
  enum class Mark : uint8_t { kNone, kObstacle, kPassed, kHit };

  double FromMiddle_m(core::CellIndex cell) const {
    return geometry::Norm(map_.grid(level_).CenterInMap(cell) - middle_);
  }
  std::optional<size_t> IndexOf(core::CellIndex cell) const {
    const int x = cell.x - corner_.x;
    const int y = cell.y - corner_.y;
    if (x < 0 || y < 0 || x >= side_ || y >= side_) return std::nullopt;
    return static_cast<size_t>(y) * static_cast<size_t>(side_) +
           static_cast<size_t>(x);
  }
  void Reach(core::CellIndex cell, std::vector<core::CellIndex>& open) {
    const std::optional<size_t> i = IndexOf(cell);
    if (!i || marks_[*i] != Mark::kNone || map_.IsFree(level_, cell)) return;
    marks_[*i] = Mark::kObstacle;
    open.push_back(cell);
  }
  // What was hit stays so.
  void Set(core::CellIndex cell, Mark mark) {
    const std::optional<size_t> i = IndexOf(cell);
    if (i && marks_[*i] != Mark::kNone) marks_[*i] = std::max(marks_[*i], mark);
  }
  int Count(Mark mark, double beside_m) const {
    int count = 0;
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) {
        const core::CellIndex cell{corner_.x + x, corner_.y + y};
        count +=
            marks_[*IndexOf(cell)] == mark && FromMiddle_m(cell) >= beside_m;
      }
    }
    return count;
  }

  const traversability::NavigationMap& map_;
  int level_;
  geometry::Vec2 middle_;
  int reach_;
  int side_;
  core::CellIndex corner_;
  std::vector<Mark> marks_;
};

}  // namespace

bool IsSeenThrough(const traversability::NavigationMap& map, int level,
                   const ScanFromPlace& scan, double within_m,
                   const core::RobotModel& robot) {
  Patch patch(map, level, scan.map_from_base.translation);
  if (!patch.MarkObstacles(within_m)) return false;
  const geometry::Vec2 laser = scan.map_from_base * scan.laser_in_base;
  for (const geometry::Vec2& end : scan.ends_in_base) {
    patch.Pass(laser, scan.map_from_base * end);
  }
  // Where the robot itself is, a beam says nothing.
  const double beside_m = std::min(robot.half_width_m, robot.front_m);
  const int passed = patch.CountPassed(beside_m);
  return passed * map.resolution_m() >= kMinSeenThrough_m &&
         patch.CountHit() <= kMaxGhostHitShare * passed;
}

}  // namespace treeline::behavior

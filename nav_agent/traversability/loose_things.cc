#include "nav_agent/traversability/loose_things.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::traversability {
namespace {

// Ground scatters by a voxel; what differs by more is not level.
constexpr double kLevelVoxels = 1.01;
// Half a voxel more is a hole, or other ground.
constexpr double kOffVoxels = 1.5;

// Takes one thing after the other from a level.
class ThingFinder {
 public:
  ThingFinder(const NavigationMap& map, int level, double max_size_m)
      : map_(map),
        level_(level),
        grid_(map.grid(level)),
        max_cells_(static_cast<int>(max_size_m / map.resolution_m())),
        is_known_(grid_.cells.size(), 0) {}

  void AddAll(std::vector<LooseThing>& things) {
    for (int y = 0; y < grid_.height; ++y) {
      for (int x = 0; x < grid_.width; ++x) {
        if (!IsThing({x, y}) || is_known_[grid_.IndexOf({x, y})] != 0) continue;
        std::optional<LooseThing> thing = From({x, y});
        if (thing.has_value()) things.push_back(*std::move(thing));
      }
    }
  }

 private:
  bool IsThing(core::CellIndex cell) const {
    return grid_.Contains(cell) && !map_.IsFree(level_, cell);
  }
  double Surface_m(int level, core::CellIndex cell) const {
    return map_.traversable()
               .levels[static_cast<size_t>(level)]
               .height_m[grid_.IndexOf(cell)] +
           0.5 * map_.resolution_m();
  }

  // All that hangs together is known afterwards, whether it is loose or not.
  std::optional<LooseThing> From(core::CellIndex first) {
    LooseThing thing;
    thing.level = level_;
    thing.cells.push_back(first);
    is_known_[grid_.IndexOf(first)] = 1;
    bool is_loose = true;
    core::CellIndex low = first;
    core::CellIndex high = first;
    double ground_m = 0;
    int grounds = 0;
    double lowest_m = std::numeric_limits<double>::infinity();
    double highest_m = -lowest_m;
    for (size_t i = 0; i < thing.cells.size(); ++i) {
      const core::CellIndex at = thing.cells[i];
      low = {std::min(low.x, at.x), std::min(low.y, at.y)};
      high = {std::max(high.x, at.x), std::max(high.y, at.y)};
      for (int k = 0; k < 9; ++k) {
        const core::CellIndex next = {at.x + k % 3 - 1, at.y + k / 3 - 1};
        if (!grid_.Contains(next)) {
          is_loose = false;
        } else if (IsThing(next)) {
          if (is_known_[grid_.IndexOf(next)] != 0) continue;
          is_known_[grid_.IndexOf(next)] = 1;
          thing.cells.push_back(next);
        } else {
          const double surface_m = Surface_m(level_, next);
          is_loose = is_loose && std::isfinite(surface_m);
          ground_m += surface_m;
          ++grounds;
          lowest_m = std::min(lowest_m, surface_m);
          highest_m = std::max(highest_m, surface_m);
        }
      }
    }
    const double voxel_m = map_.resolution_m();
    if (!is_loose || high.x - low.x >= max_cells_ ||
        high.y - low.y >= max_cells_ ||
        highest_m - lowest_m > kLevelVoxels * voxel_m) {
      return std::nullopt;
    }
    thing.ground_m = ground_m / grounds;
    if (!StandsOnGround(thing)) return std::nullopt;
    thing.middle_in_map =
        0.5 * (grid_.CenterInMap(low) + grid_.CenterInMap(high));
    thing.radius_m =
        0.5 * voxel_m * std::hypot(high.x - low.x + 1, high.y - low.y + 1);
    return thing;
  }

  bool StandsOnGround(const LooseThing& thing) const {
    const double off_m = kOffVoxels * map_.resolution_m();
    return std::ranges::none_of(thing.cells, [&](core::CellIndex cell) {
      if (Surface_m(level_, cell) < thing.ground_m - off_m) return true;
      for (int level = 0; level < map_.levels(); ++level) {
        if (level != level_ && map_.IsFree(level, cell) &&
            std::abs(Surface_m(level, cell) - thing.ground_m) <=
                map_.options().max_rise_m) {
          return true;
        }
      }
      return false;
    });
  }

  const NavigationMap& map_;
  const int level_;
  const core::OccupancyGrid& grid_;
  const int max_cells_;
  std::vector<uint8_t> is_known_;
};

auto KeyOf(int level, core::CellIndex cell) {
  return std::tuple(level, cell.y, cell.x);
}

}  // namespace

std::vector<LooseThing> FindLooseThings(const NavigationMap& map,
                                        double max_size_m) {
  std::vector<LooseThing> things;
  for (int level = 0; level < map.levels(); ++level) {
    ThingFinder(map, level, max_size_m).AddAll(things);
  }
  return things;
}

FreedCells::FreedCells(std::vector<Cell> cells) : cells_(std::move(cells)) {
  std::ranges::sort(cells_, [](const Cell& a, const Cell& b) {
    return KeyOf(a.level, a.cell) < KeyOf(b.level, b.cell);
  });
}

std::optional<float> FreedCells::Ground_m(int level,
                                          core::CellIndex cell) const {
  const auto at =
      std::lower_bound(cells_.begin(), cells_.end(), KeyOf(level, cell),
                       [](const Cell& a, const auto& key) {
                         return KeyOf(a.level, a.cell) < key;
                       });
  if (at == cells_.end() || at->level != level || at->cell != cell) {
    return std::nullopt;
  }
  return at->ground_m;
}

absl::StatusOr<NavigationMap> MapWithFreed(const NavigationMap& map,
                                           const FreedCells& freed) {
  TraversableMap open = map.traversable();
  for (const FreedCells::Cell& cell : freed.cells()) {
    if (cell.level < 0 || cell.level >= map.levels() ||
        !map.grid(cell.level).Contains(cell.cell)) {
      return absl::InvalidArgumentError(
          absl::StrCat("a cell that was freed is not on the map: level ",
                       cell.level, ", ", cell.cell.x, ", ", cell.cell.y));
    }
    TraversableLevel& level = open.levels[static_cast<size_t>(cell.level)];
    const size_t i = level.grid.IndexOf(cell.cell);
    level.grid.cells[i] = core::Occupancy::kFree;
    level.height_m[i] =
        cell.ground_m - static_cast<float>(0.5 * map.resolution_m());
    level.slope_rad[i] = 0;
    level.clearance_m[i] = std::numeric_limits<float>::infinity();
  }
  return NavigationMap::Make(std::move(open), map.options());
}

}  // namespace treeline::traversability

#include "nav_agent/zones/zone_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::zones {
namespace {

constexpr float kNoLimit = std::numeric_limits<float>::infinity();
constexpr std::array<core::CellIndex, 8> kBeside = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
// Against a direction is what has more than this of it: less is rounding.
constexpr double kAgainst = 1e-3;

// Adds the cells that a line goes through: points on it lie half a cell apart
// at most, so what is left out is a corner that is hardly cut.
void AddLine(geometry::Vec2 from, geometry::Vec2 to,
             const core::OccupancyGrid& grid, std::vector<size_t>& cells) {
  const double length = geometry::Norm(to - from);
  const int steps = std::max(1, static_cast<int>(std::ceil(2 * length)));
  for (int i = 0; i <= steps; ++i) {
    const geometry::Vec2 at =
        from + (static_cast<double>(i) / steps) * (to - from);
    const core::CellIndex cell = {static_cast<int>(std::floor(at.x)),
                                  static_cast<int>(std::floor(at.y))};
    if (grid.Contains(cell)) cells.push_back(grid.IndexOf(cell));
  }
}

// Adds the cells of one row whose centres lie within the corners (in cells).
void AddRow(const std::vector<geometry::Vec2>& corners, int row,
            const core::OccupancyGrid& grid, std::vector<size_t>& cells) {
  const double y = row + 0.5;
  std::vector<double> crossings;
  for (size_t i = 0; i < corners.size(); ++i) {
    const geometry::Vec2 a = corners[i];
    const geometry::Vec2 b = corners[(i + 1) % corners.size()];
    if ((a.y > y) == (b.y > y)) continue;
    crossings.push_back(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
  }
  std::ranges::sort(crossings);
  for (size_t i = 0; i + 1 < crossings.size(); i += 2) {
    const double last = std::min<double>(grid.width, crossings[i + 1]) - 0.5;
    for (int x = static_cast<int>(std::max(0.0, std::ceil(crossings[i] - 0.5)));
         x <= last && x < grid.width; ++x) {
      cells.push_back(grid.IndexOf({x, row}));
    }
  }
}

// Clips a line to a box about the grid, so that a corner a hundred kilometres
// away costs no more than one nearby; false if nothing is left.
bool ClipToGrid(const core::OccupancyGrid& grid, geometry::Vec2& from,
                geometry::Vec2& to) {
  double begin = 0;
  double end = 1;
  const geometry::Vec2 way = to - from;
  const auto clip = [&](double at, double step, double high) {
    // Within [-1, high + 1].
    if (step == 0) return at >= -1 && at <= high + 1;
    const double one = (-1 - at) / step;
    const double other = (high + 1 - at) / step;
    begin = std::max(begin, std::min(one, other));
    end = std::min(end, std::max(one, other));
    return begin <= end;
  };
  if (!clip(from.x, way.x, grid.width) || !clip(from.y, way.y, grid.height)) {
    return false;
  }
  const geometry::Vec2 start = from;
  from = start + begin * way;
  to = start + end * way;
  return true;
}

// The values of a mask on the cells of a map: each cell has what lies on its
// centre, and all values whose own centres lie in it. So no cell of a mask is
// lost, whatever its resolution and the way it lies.
void ForEachValue(
    const core::ValueGrid& mask, const core::OccupancyGrid& grid,
    const std::function<void(size_t cell, std::optional<int> value)>& take) {
  const geometry::Rigid2 mask_from_grid =
      mask.map_from_grid.Inverse() * grid.map_from_grid;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const geometry::Vec2 at =
          mask_from_grid * geometry::Vec2{(x + 0.5) * grid.resolution_m,
                                          (y + 0.5) * grid.resolution_m};
      const core::CellIndex cell = {
          static_cast<int>(std::floor(at.x / mask.resolution_m)),
          static_cast<int>(std::floor(at.y / mask.resolution_m))};
      if (mask.Contains(cell)) take(grid.IndexOf({x, y}), mask.At(cell));
    }
  }
  if (mask.resolution_m > grid.resolution_m) return;
  const geometry::Rigid2 grid_from_mask = mask_from_grid.Inverse();
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const geometry::Vec2 at =
          grid_from_mask * geometry::Vec2{(x + 0.5) * mask.resolution_m,
                                          (y + 0.5) * mask.resolution_m};
      const core::CellIndex cell = {
          static_cast<int>(std::floor(at.x / grid.resolution_m)),
          static_cast<int>(std::floor(at.y / grid.resolution_m))};
      if (grid.Contains(cell)) take(grid.IndexOf(cell), mask.At({x, y}));
    }
  }
}

bool LeavesSomething(const traversability::TraversableMap& map,
                     const ZoneMap& zones) {
  for (size_t level = 0; level < map.levels.size(); ++level) {
    const core::OccupancyGrid& grid = map.levels[level].grid;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        if (grid.At({x, y}) == core::Occupancy::kFree &&
            !zones.IsKeptOut(static_cast<int>(level), core::CellIndex{x, y})) {
          return true;
        }
      }
    }
  }
  return false;
}

}  // namespace

std::vector<size_t> CellsOf(const Zone& zone, const core::OccupancyGrid& grid) {
  const geometry::Rigid2 grid_from_map = grid.map_from_grid.Inverse();
  std::vector<geometry::Vec2> corners;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const geometry::Vec2& corner : zone.corners_in_map) {
    corners.push_back(1 / grid.resolution_m * (grid_from_map * corner));
    lowest = std::min(lowest, corners.back().y);
    highest = std::max(highest, corners.back().y);
  }
  std::vector<size_t> cells;
  for (int row = static_cast<int>(std::max(0.0, std::floor(lowest)));
       row < grid.height && row <= highest; ++row) {
    AddRow(corners, row, grid, cells);
  }
  for (size_t i = 0; i < corners.size(); ++i) {
    geometry::Vec2 from = corners[i];
    geometry::Vec2 to = corners[(i + 1) % corners.size()];
    if (ClipToGrid(grid, from, to)) AddLine(from, to, grid, cells);
  }
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

ZoneMap::ZoneMap(const traversability::TraversableMap& map)
    : grid_(map.levels.front().grid), levels_(map.levels.size()) {
  grid_.cells.clear();
}

absl::StatusOr<std::shared_ptr<const ZoneMap>> ZoneMap::Make(
    const traversability::TraversableMap& map, std::span<const Zone> zones,
    std::span<const ZoneMask> masks, double full_mps) {
  if (map.levels.empty()) return absl::InvalidArgumentError("an empty map");
  TL_RETURN_IF_ERROR(CheckZones(zones, static_cast<int>(map.levels.size())));
  std::shared_ptr<ZoneMap> made(new ZoneMap(map));
  for (const Zone& zone : zones) {
    const std::vector<size_t> cells = CellsOf(zone, made->grid_);
    if (cells.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("zone '", zone.name, "' lies beside the map"));
    }
    made->AddCells(zone, cells);
  }
  made->AddDirections(zones);
  for (const ZoneMask& mask : masks) {
    if (mask.level < 0 ||
        static_cast<size_t>(mask.level) >= map.levels.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat("mask ", mask.name, " is of level ", mask.level,
                       "; the map has 0..", map.levels.size() - 1));
    }
    made->AddMask(mask, full_mps);
  }
  for (const Level& level : made->levels_) {
    made->kept_out_cells_ += std::ranges::count_if(
        level.keep_out, [](uint8_t is) { return is != 0; });
  }
  made->has_keep_out_ = made->kept_out_cells_ > 0;
  if (made->has_keep_out_ && !LeavesSomething(map, *made)) {
    return absl::InvalidArgumentError(
        "the keep-out zones leave nothing to drive on");
  }
  if (made->has_keep_out_) made->MeasureWaysOut(map);
  return made;
}

void ZoneMap::AddCells(const Zone& zone, const std::vector<size_t>& cells) {
  Level& level = levels_[static_cast<size_t>(zone.level)];
  const size_t all =
      static_cast<size_t>(grid_.width) * static_cast<size_t>(grid_.height);
  if (zone.kind == ZoneKind::kKeepOut) {
    level.keep_out.resize(all, 0);
    for (const size_t cell : cells) level.keep_out[cell] = 1;
    keep_out_zones_.push_back(zone);
  } else if (zone.kind == ZoneKind::kSpeed) {
    level.max_mps.resize(all, kNoLimit);
    has_speed_ = true;
    for (const size_t cell : cells) {
      level.max_mps[cell] =
          std::min(level.max_mps[cell], static_cast<float>(zone.max_mps));
    }
  }
}

void ZoneMap::AddDirections(std::span<const Zone> zones) {
  // From a set and a zone that is added to it to the set with it.
  std::map<std::pair<int32_t, size_t>, int32_t> with;
  for (size_t i = 0; i < zones.size(); ++i) {
    const Zone& zone = zones[i];
    if (zone.kind != ZoneKind::kOneWay) continue;
    has_one_way_ = true;
    const double yaw_rad = zone.direction_rad - grid_.map_from_grid.yaw_rad;
    Level& level = levels_[static_cast<size_t>(zone.level)];
    level.directions.resize(
        static_cast<size_t>(grid_.width) * static_cast<size_t>(grid_.height),
        0);
    for (const size_t cell : CellsOf(zone, grid_)) {
      int32_t& set = level.directions[cell];
      const auto [known, is_new] = with.try_emplace({set, i}, 0);
      if (is_new) {
        known->second = static_cast<int32_t>(direction_sets_.size());
        direction_sets_.push_back(direction_sets_[static_cast<size_t>(set)]);
        direction_sets_.back().push_back(
            {std::cos(yaw_rad), std::sin(yaw_rad)});
      }
      set = known->second;
    }
  }
}

void ZoneMap::AddMask(const ZoneMask& mask, double full_mps) {
  Level& level = levels_[static_cast<size_t>(mask.level)];
  const size_t all =
      static_cast<size_t>(grid_.width) * static_cast<size_t>(grid_.height);
  if (mask.kind == ZoneKind::kKeepOut) {
    level.keep_out.resize(all, 0);
    keep_out_masks_.push_back(mask);
    ForEachValue(*mask.values, grid_, [&](size_t cell, std::optional<int> is) {
      if (mask.KeepsOut(is)) level.keep_out[cell] = 1;
    });
    return;
  }
  level.max_mps.resize(all, kNoLimit);
  has_speed_ = true;
  ForEachValue(*mask.values, grid_, [&](size_t cell, std::optional<int> is) {
    const std::optional<double> limit_mps = mask.Limit_mps(is, full_mps);
    if (!limit_mps.has_value()) return;
    level.max_mps[cell] =
        std::min(level.max_mps[cell], static_cast<float>(*limit_mps));
  });
}

// Dijkstra, from the cells beside free ground that is not kept out of.
void ZoneMap::MeasureWaysOut(const traversability::TraversableMap& map) {
  using Open = std::pair<float, size_t>;
  const auto width = static_cast<size_t>(grid_.width);
  for (size_t number = 0; number < levels_.size(); ++number) {
    Level& level = levels_[number];
    if (level.keep_out.empty()) continue;
    const core::OccupancyGrid& ground = map.levels[number].grid;
    level.way_out_m.assign(level.keep_out.size(), kNoLimit);
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    // Of the cells beside one that are free, and kept out of or not.
    const auto for_each_beside = [&](size_t cell, bool is_kept_out,
                                     const auto& take) {
      for (const core::CellIndex& step : kBeside) {
        const core::CellIndex beside = {
            static_cast<int>(cell % width) + step.x,
            static_cast<int>(cell / width) + step.y};
        if (!grid_.Contains(beside)) continue;
        const size_t next = grid_.IndexOf(beside);
        if (ground.cells[next] != core::Occupancy::kFree ||
            (level.keep_out[next] != 0) != is_kept_out) {
          continue;
        }
        take(next, static_cast<float>(grid_.resolution_m *
                                      std::hypot(step.x, step.y)));
      }
    };
    const auto reach = [&](size_t cell, float way_m) {
      if (way_m >= level.way_out_m[cell]) return;
      level.way_out_m[cell] = way_m;
      open.push({way_m, cell});
    };
    for (size_t cell = 0; cell < level.keep_out.size(); ++cell) {
      if (level.keep_out[cell] == 0 ||
          ground.cells[cell] != core::Occupancy::kFree) {
        continue;
      }
      for_each_beside(cell, false,
                      [&](size_t, float step_m) { reach(cell, step_m); });
    }
    while (!open.empty()) {
      const auto [way_m, cell] = open.top();
      open.pop();
      if (way_m > level.way_out_m[cell]) continue;
      const float so_far_m = way_m;
      for_each_beside(cell, true, [&](size_t next, float step_m) {
        reach(next, so_far_m + step_m);
      });
    }
  }
}

double ZoneMap::MaxSpeed_mps(int level, geometry::Vec2 point_in_map) const {
  if (!has_speed_ || level < 0 ||
      static_cast<size_t>(level) >= levels_.size()) {
    return kNoLimit;
  }
  const std::vector<float>& max_mps = LevelOf(level).max_mps;
  const core::CellIndex cell = grid_.CellOf(point_in_map);
  return max_mps.empty() || !grid_.Contains(cell)
             ? kNoLimit
             : max_mps[grid_.IndexOf(cell)];
}

bool ZoneMap::ForbidsHeading(int level, core::CellIndex cell,
                             geometry::Vec2 heading_in_grid) const {
  if (!has_one_way_ || level < 0 ||
      static_cast<size_t>(level) >= levels_.size() || !grid_.Contains(cell)) {
    return false;
  }
  const std::vector<int32_t>& directions = LevelOf(level).directions;
  if (directions.empty()) return false;
  const int32_t set = directions[grid_.IndexOf(cell)];
  return std::ranges::any_of(
      direction_sets_[static_cast<size_t>(set)], [&](geometry::Vec2 direction) {
        return geometry::Dot(direction, heading_in_grid) < -kAgainst;
      });
}

std::string ZoneMap::KeepOutName(int level, geometry::Vec2 point_in_map) const {
  if (!IsKeptOut(level, point_in_map)) return "";
  for (const Zone& zone : keep_out_zones_) {
    if (zone.level == level && Contains(zone, point_in_map)) return zone.name;
  }
  const size_t at = grid_.IndexOf(grid_.CellOf(point_in_map));
  // On a side, or of a mask.
  for (const Zone& zone : keep_out_zones_) {
    if (zone.level != level) continue;
    const std::vector<size_t> cells = CellsOf(zone, grid_);
    if (std::ranges::binary_search(cells, at)) return zone.name;
  }
  for (const ZoneMask& mask : keep_out_masks_) {
    if (mask.level == level) return mask.name;
  }
  return "";
}

}  // namespace treeline::zones

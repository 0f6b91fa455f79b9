#include "nav_agent/mapping/grid_mapping.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/map_file.h"

namespace treeline::mapping {
namespace {

struct Beam {
  geometry::Vec2 end;  // in the map
  bool hits = false;   // something, there
};

struct Counts {
  uint16_t hits = 0;
  uint16_t beams = 0;
};

// What a beam tells; nothing if it tells nothing.
bool ReadBeam(const GridScan& scan, const core::RangeSensorInfo& laser,
              int beam, const GridMappingOptions& options, Beam* out) {
  double range_m = scan.ranges_m[static_cast<size_t>(beam)];
  out->hits = true;
  if (range_m == core::kNoReturn ||
      (laser.range_max_m > 0 && range_m >= laser.range_max_m)) {
    if (options.no_return_clears_m <= 0) return false;
    range_m = std::min(options.no_return_clears_m, options.max_range_m);
    out->hits = false;
  }
  if (!std::isfinite(range_m) || range_m <= laser.range_min_m) return false;
  if (range_m > options.max_range_m) {
    range_m = options.max_range_m;
    out->hits = false;
  }
  const double angle_rad = laser.AngleOf_rad(beam);
  out->end =
      scan.map_from_laser * geometry::Vec2{range_m * std::cos(angle_rad),
                                           range_m * std::sin(angle_rad)};
  return true;
}

struct Bounds {
  geometry::Vec2 low = {std::numeric_limits<double>::infinity(),
                        std::numeric_limits<double>::infinity()};
  geometry::Vec2 high = {-std::numeric_limits<double>::infinity(),
                         -std::numeric_limits<double>::infinity()};

  void Add(geometry::Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

void CountBeam(Counts* cell, bool hit) {
  // Stops at what 16 bits hold; the part stays what it was.
  if (cell->beams == std::numeric_limits<uint16_t>::max()) return;
  ++cell->beams;
  if (hit) ++cell->hits;
}

constexpr double kNever = std::numeric_limits<double>::infinity();

// Walks over the cells from `begin` to `end`, in cells (Amanatides and Woo,
// "A Fast Voxel Traversal Algorithm", 1987).
template <typename Visit>
void WalkCells(geometry::Vec2 begin, geometry::Vec2 end, const Visit& visit) {
  int x = static_cast<int>(std::floor(begin.x));
  int y = static_cast<int>(std::floor(begin.y));
  const int end_x = static_cast<int>(std::floor(end.x));
  const int end_y = static_cast<int>(std::floor(end.y));
  const geometry::Vec2 d = end - begin;
  const int step_x = d.x > 0 ? 1 : -1;
  const int step_y = d.y > 0 ? 1 : -1;
  const double per_x = d.x != 0 ? std::abs(1 / d.x) : kNever;
  const double per_y = d.y != 0 ? std::abs(1 / d.y) : kNever;
  const auto first = [](double at, double delta, double per) {
    if (delta == 0) return kNever;
    const double cell = std::floor(at);
    return (delta > 0 ? cell + 1 - at : at - cell) * per;
  };
  double next_x = first(begin.x, d.x, per_x);
  double next_y = first(begin.y, d.y, per_y);
  const int steps = std::abs(end_x - x) + std::abs(end_y - y);
  for (int i = 0; i < steps; ++i) {
    visit(x, y);
    if (next_x < next_y) {
      x += step_x;
      next_x += per_x;
    } else {
      y += step_y;
      next_y += per_y;
    }
  }
}

}  // namespace

absl::Status GridMappingOptions::Validate() const {
  if (!(resolution_m > 0) || !(max_range_m > resolution_m) ||
      !(no_return_clears_m >= 0) || min_beams < 1 || !(occupied_part > 0) ||
      !(occupied_part <= 1) || !(border_m >= 0)) {
    return absl::InvalidArgumentError(
        "grid mapping: resolution_m, max_range_m and min_beams must be above "
        "0, occupied_part from 0 to 1");
  }
  return absl::OkStatus();
}

absl::StatusOr<core::OccupancyGrid> MapGrid(std::span<const GridScan> scans,
                                            const core::RangeSensorInfo& laser,
                                            const GridMappingOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  Bounds bounds;
  Beam beam;
  for (const GridScan& scan : scans) {
    if (static_cast<int>(scan.ranges_m.size()) != laser.beams) {
      return absl::InvalidArgumentError(
          absl::StrCat("a scan of ", scan.ranges_m.size(),
                       " beams from a laser of ", laser.beams));
    }
    bool sees = false;
    for (int i = 0; i < laser.beams; ++i) {
      if (!ReadBeam(scan, laser, i, options, &beam)) continue;
      sees = true;
      bounds.Add(beam.end);
    }
    if (sees) bounds.Add(scan.map_from_laser.translation);
  }
  const geometry::Vec2 size = bounds.high - bounds.low;
  if (!std::isfinite(size.x) || !std::isfinite(size.y)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "no scan has seen anything within ", options.max_range_m,
        " m, nor farther than the laser's range_max; are ranges in metres?"));
  }
  const double width =
      std::ceil((size.x + 2 * options.border_m) / options.resolution_m) + 1;
  const double height =
      std::ceil((size.y + 2 * options.border_m) / options.resolution_m) + 1;
  if (width * height > static_cast<double>(core::kMaxMapCells)) {
    return absl::ResourceExhaustedError(
        absl::StrCat("a map of ", width, " x ", height, " cells"));
  }
  const geometry::Vec2 origin =
      bounds.low - options.border_m * geometry::Vec2{1, 1};
  core::OccupancyGrid grid = core::OccupancyGrid::Filled(
      static_cast<int>(width), static_cast<int>(height), options.resolution_m,
      {origin, 0}, core::Occupancy::kUnknown);
  std::vector<Counts> counts(grid.cells.size());
  const double scale = 1 / options.resolution_m;
  for (const GridScan& scan : scans) {
    const geometry::Vec2 begin =
        scale * (scan.map_from_laser.translation - origin);
    for (int i = 0; i < laser.beams; ++i) {
      if (!ReadBeam(scan, laser, i, options, &beam)) continue;
      const geometry::Vec2 end = scale * (beam.end - origin);
      WalkCells(begin, end, [&](int x, int y) {
        CountBeam(&counts[grid.IndexOf({x, y})], false);
      });
      if (beam.hits) {
        const core::CellIndex cell = {static_cast<int>(std::floor(end.x)),
                                      static_cast<int>(std::floor(end.y))};
        CountBeam(&counts[grid.IndexOf(cell)], true);
      }
    }
  }
  for (size_t i = 0; i < counts.size(); ++i) {
    if (counts[i].beams < options.min_beams) continue;
    grid.cells[i] = counts[i].hits >= options.occupied_part * counts[i].beams
                        ? core::Occupancy::kOccupied
                        : core::Occupancy::kFree;
  }
  return grid;
}

}  // namespace treeline::mapping

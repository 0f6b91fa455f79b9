#include "nav_agent/localization/laser_level_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/localization/laser_layer.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {
namespace {

bool AnyOccupied(const octree::VoxelMap& voxels, int x, int y, int begin_z,
                 int end_z) {
  for (int z = std::max(begin_z, 0); z < std::min(end_z, voxels.size().z);
       ++z) {
    const uint64_t word =
        voxels.Occupied(x, y)[static_cast<size_t>(z) / 64] >> (z % 64);
    if ((word & 1) != 0) return true;
  }
  return false;
}

// Voxels that reach into a layer, or are within one voxel of it.
core::OccupancyGrid LayerOf(const octree::VoxelMap& voxels,
                            const geometry::Rigid2& map_from_grid,
                            double begin_m, double end_m) {
  const double r = voxels.resolution_m();
  core::OccupancyGrid grid =
      core::OccupancyGrid::Filled(voxels.size().x, voxels.size().y, r,
                                  map_from_grid, core::Occupancy::kFree);
  const int begin_z =
      static_cast<int>(std::floor(begin_m / r + 1e-6)) - voxels.lowest().z - 1;
  const int end_z =
      static_cast<int>(std::ceil(end_m / r - 1e-6)) - voxels.lowest().z + 1;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (AnyOccupied(voxels, x, y, begin_z, end_z)) {
        grid.Set({x, y}, core::Occupancy::kOccupied);
      }
    }
  }
  return grid;
}

// Only cells with a free one beside them: a beam does not get to those within.
// Else whatever ends above or in the top of a platform, which fills a layer,
// would fit it.
core::OccupancyGrid OutlinesOf(const core::OccupancyGrid& grid) {
  core::OccupancyGrid outlines = grid;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const bool is_within =
          grid.AtOrUnknown({x + 1, y}) == core::Occupancy::kOccupied &&
          grid.AtOrUnknown({x - 1, y}) == core::Occupancy::kOccupied &&
          grid.AtOrUnknown({x, y + 1}) == core::Occupancy::kOccupied &&
          grid.AtOrUnknown({x, y - 1}) == core::Occupancy::kOccupied;
      if (is_within) outlines.Set({x, y}, core::Occupancy::kFree);
    }
  }
  return outlines;
}

absl::StatusOr<OccupancyLayers> LayersOf(const octree::VoxelMap& voxels,
                                         const geometry::Rigid2& map_from_grid,
                                         const LaserLevelOptions& options) {
  const double r = voxels.resolution_m();
  OccupancyLayers layers;
  layers.layer_m = options.layer_m;
  layers.lowest_m = voxels.lowest().z * r;
  const int count =
      static_cast<int>(std::ceil(voxels.size().z * r / options.layer_m - 1e-6));
  const double bytes =
      4.0 * (voxels.size().x + 2) * (voxels.size().y + 2) * std::max(count, 1);
  if (bytes > static_cast<double>(options.max_bytes)) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the map's ", count, " layers of ", voxels.size().x, " x ",
        voxels.size().y, " cells would take more than ",
        options.max_bytes >> 20, " MiB; thicker layers take less"));
  }
  for (int i = 0; i < count; ++i) {
    const double begin_m = layers.lowest_m + i * options.layer_m;
    layers.grids.push_back(OutlinesOf(
        LayerOf(voxels, map_from_grid, begin_m, begin_m + options.layer_m)));
  }
  return layers;
}

// The height of each free cell's ground, and of that of the nearest free cell
// elsewhere, going by sides. Other ground may be the top of a table.
std::vector<float> SpreadHeights(
    const traversability::TraversableLevel& level) {
  std::vector<float> heights_m = level.height_m;
  for (size_t i = 0; i < heights_m.size(); ++i) {
    if (level.grid.cells[i] != core::Occupancy::kFree) {
      heights_m[i] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  std::vector<core::CellIndex> border;
  for (int y = 0; y < level.grid.height; ++y) {
    for (int x = 0; x < level.grid.width; ++x) {
      if (!std::isnan(heights_m[level.grid.IndexOf({x, y})])) {
        border.push_back({x, y});
      }
    }
  }
  for (size_t i = 0; i < border.size(); ++i) {
    const core::CellIndex at = border[i];
    const std::array<core::CellIndex, 4> sides = {{{at.x + 1, at.y},
                                                   {at.x - 1, at.y},
                                                   {at.x, at.y + 1},
                                                   {at.x, at.y - 1}}};
    for (const core::CellIndex& side : sides) {
      if (!level.grid.Contains(side)) continue;
      float& height_m = heights_m[level.grid.IndexOf(side)];
      if (!std::isnan(height_m)) continue;
      height_m = heights_m[level.grid.IndexOf(at)];
      border.push_back(side);
    }
  }
  return heights_m;
}

// The voxels are in the frame of the map; or, with their lowest at (0, 0), in
// that of the cells, which may be anywhere and turned.
bool HaveSameCells(const core::OccupancyGrid& grid,
                   const octree::VoxelMap& voxels) {
  const double r = voxels.resolution_m();
  const octree::VoxelIndex lowest = voxels.lowest();
  const bool is_in_map =
      geometry::Norm(grid.map_from_grid.translation -
                     geometry::Vec2{lowest.x * r, lowest.y * r}) < 1e-6 &&
      grid.map_from_grid.yaw_rad == 0;
  const bool is_in_grid = lowest.x == 0 && lowest.y == 0;
  return grid.width == voxels.size().x && grid.height == voxels.size().y &&
         std::abs(grid.resolution_m - r) < 1e-6 && (is_in_map || is_in_grid);
}

}  // namespace

absl::Status LaserLevelOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser levels: layer_m", layer_m, 0.02, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser levels: max_rise_m", max_rise_m, 0.001, 1));
  TL_RETURN_IF_ERROR(base::CheckRange(
      "laser levels: max_bytes", static_cast<double>(max_bytes), 1, 0x1p32));
  return field.Validate();
}

absl::StatusOr<LaserLevelMap> LaserLevelMap::Make(
    const octree::VoxelMap& voxels,
    const traversability::TraversableMap& traversable,
    const LaserLevelOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (traversable.levels.empty()) {
    return absl::InvalidArgumentError("laser levels: there is no level");
  }
  LaserLevelMap map;
  map.resolution_m_ = voxels.resolution_m();
  map.max_rise_m_ = options.max_rise_m;
  map.cells_ = traversable.levels[0].grid;
  for (size_t i = 0; i < traversable.levels.size(); ++i) {
    const traversability::TraversableLevel& level = traversable.levels[i];
    if (!HaveSameCells(level.grid, voxels) ||
        level.grid.map_from_grid != map.cells_.map_from_grid ||
        level.height_m.size() != level.grid.cells.size()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "laser levels: level ", i,
          " is not of the same cells as the voxels; ", "another resolution?"));
    }
    std::vector<float> heights_m = level.height_m;
    for (float& height_m : heights_m) {
      height_m += static_cast<float>(0.5 * map.resolution_m_);
    }
    map.heights_m_.push_back(std::move(heights_m));
    for (int y = 0; y < level.grid.height; ++y) {
      for (int x = 0; x < level.grid.width; ++x) {
        if (level.grid.At({x, y}) != core::Occupancy::kFree) continue;
        const double height_m = map.heights_m_[i][level.grid.IndexOf({x, y})];
        const geometry::Vec2 center = level.grid.CenterInMap({x, y});
        const auto ground = map.GroundNear(center, height_m);
        if (!ground.has_value() || ground->level != static_cast<int>(i)) {
          continue;
        }
        map.free_places_.push_back({center, *ground});
      }
    }
  }
  if (map.free_places_.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("laser levels: none of the cells of ",
                     traversable.levels.size(), " levels is free"));
  }
  TL_ASSIGN_OR_RETURN(const OccupancyLayers layers,
                      LayersOf(voxels, map.cells_.map_from_grid, options));
  TL_ASSIGN_OR_RETURN(map.field_,
                      LikelihoodField::CreateLayered(layers, options.field));
  return map;
}

std::optional<core::LevelPlace> LaserLevelMap::GroundNear(
    geometry::Vec2 point, double height_m) const {
  const core::CellIndex cell = cells_.CellOf(point);
  if (!cells_.Contains(cell)) return std::nullopt;
  const size_t at = cells_.IndexOf(cell);
  std::optional<core::LevelPlace> nearest;
  double best_m = max_rise_m_;
  for (size_t i = 0; i < heights_m_.size(); ++i) {
    const double ground_m = heights_m_[i][at];
    const double away_m = std::abs(ground_m - height_m);
    // Not so for NaN.
    if (away_m < best_m - kSameHeight_m) {
      best_m = away_m;
      nearest = {.level = static_cast<int>(i), .height_m = ground_m};
    }
  }
  return nearest;
}

std::optional<core::LevelPlace> LaserLevelMap::GroundOf(geometry::Vec2 point,
                                                        int level) const {
  const core::CellIndex cell = cells_.CellOf(point);
  if (!cells_.Contains(cell) || level < 0 || level >= levels()) {
    return std::nullopt;
  }
  const double height_m =
      heights_m_[static_cast<size_t>(level)][cells_.IndexOf(cell)];
  if (std::isnan(height_m)) return std::nullopt;
  return core::LevelPlace{.level = level, .height_m = height_m};
}

core::OccupancyGrid LaserSlice(const octree::VoxelMap& voxels,
                               const traversability::TraversableLevel& level,
                               double laser_height_m) {
  core::OccupancyGrid slice = level.grid;
  const std::vector<float> heights_m = SpreadHeights(level);
  const double r = voxels.resolution_m();
  for (int y = 0; y < slice.height; ++y) {
    for (int x = 0; x < slice.width; ++x) {
      const size_t at = slice.IndexOf({x, y});
      const int z =
          std::isnan(heights_m[at])
              ? 0
              : LaserLayer(voxels, heights_m[at] + 0.5 * r + laser_height_m);
      if (!std::isnan(heights_m[at]) &&
          AnyOccupied(voxels, x, y, z - 1, z + 2)) {
        slice.cells[at] = core::Occupancy::kOccupied;
      } else if (level.grid.cells[at] != core::Occupancy::kFree) {
        slice.cells[at] = core::Occupancy::kUnknown;
      }
    }
  }
  return slice;
}

bool LaserLevelMap::IsOnGround(geometry::Vec3 point, double tolerance_m) const {
  const core::CellIndex cell = cells_.CellOf({point.x, point.y});
  if (!cells_.Contains(cell)) return false;
  const size_t at = cells_.IndexOf(cell);
  return std::ranges::any_of(
      heights_m_, [&](const std::vector<float>& heights_m) {
        return std::abs(heights_m[at] - point.z) <= tolerance_m;
      });
}

}  // namespace treeline::localization

#include "nav_agent/traversability/level_files.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/octomap/octree_file.h"

namespace treeline::traversability {
namespace {

using Color = std::array<uint8_t, 3>;
constexpr Color kOccupiedColor = {0, 0, 0};
constexpr Color kUnknownColor = {160, 160, 160};
constexpr Color kEdgeColor = {200, 30, 30};
constexpr Color kJoinColor = {90, 140, 255};

// Layers are value = round((x - offset) / unit) + 1; 0 where there is none.
struct LayerScale {
  double unit = 1;
  double offset = 0;
};
constexpr int kLayerMax = 65535;

core::GreyPicture PictureOfLayer(const core::OccupancyGrid& grid,
                                 const std::vector<float>& values,
                                 const LayerScale& scale) {
  core::GreyPicture picture{.width = grid.width,
                            .height = grid.height,
                            .max_value = kLayerMax,
                            .values = {}};
  picture.values.reserve(values.size());
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const double value = values[grid.IndexOf({x, y})];
      double grey = 0;
      if (!std::isnan(value)) {
        grey = std::clamp<double>(
            std::round((value - scale.offset) / scale.unit) + 1, 1, kLayerMax);
      }
      picture.values.push_back(static_cast<uint16_t>(grey));
    }
  }
  return picture;
}

// White at 0, green at a third, yellow at the steepest.
Color FreeColor(double slope_rad, double max_slope_rad) {
  const double part = std::clamp(slope_rad / max_slope_rad, 0.0, 1.0);
  if (part < 0.33) {
    const auto other = static_cast<uint8_t>(255 - 155 * part / 0.33);
    return {other, 255, other};
  }
  return {static_cast<uint8_t>(100 + 155 * (part - 0.33) / 0.67), 255, 60};
}

Color CellColor(const TraversableLevel& level, size_t cell,
                double max_slope_rad) {
  switch (level.grid.cells[cell]) {
    case core::Occupancy::kFree:
      return FreeColor(level.slope_rad[cell], max_slope_rad);
    case core::Occupancy::kOccupied:
      return level.slope_rad[cell] > 1.57F ? kEdgeColor : kOccupiedColor;
    case core::Occupancy::kUnknown:
      break;
  }
  return kUnknownColor;
}

struct Layer {
  const char* name;
  const std::vector<float> TraversableLevel::*values;
  LayerScale scale;
};

// Millimetres of height and clearance, ten-thousandths of a radian of slope.
std::array<Layer, 3> LayersFrom(double lowest_m) {
  return {
      {{"height",
        &TraversableLevel::height_m,
        {.unit = 0.001, .offset = lowest_m}},
       {"slope", &TraversableLevel::slope_rad, {.unit = 0.0001, .offset = 0}},
       {"clearance",
        &TraversableLevel::clearance_m,
        {.unit = 0.001, .offset = 0}}}};
}

double LowestHeight_m(const TraversableMap& map) {
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const TraversableLevel& level : map.levels) {
    for (const float height_m : level.height_m) {
      if (height_m < lowest_m) lowest_m = height_m;
    }
  }
  return std::isfinite(lowest_m) ? lowest_m : 0;
}

std::string DescribeLayers(const TraversableMap& map, double lowest_m) {
  std::string text =
      "# Layers are 16-bit PGM pictures, rows from the top, of the cells of\n"
      "# level-N.yaml. Grey level 0: no ground. Others: the value is\n"
      "# offset + unit * (grey - 1); 65535 stands for that much or more.\n"
      "layers:\n";
  for (const Layer& layer : LayersFrom(lowest_m)) {
    absl::StrAppendFormat(&text,
                          "  %s: {unit: %g, offset: %.9g, quantity: %s}\n",
                          layer.name, layer.scale.unit, layer.scale.offset,
                          layer.scale.unit == 0.0001 ? "rad" : "m");
  }
  absl::StrAppend(&text, "levels: ", map.levels.size(),
                  "\n# Where levels are joined: a cell (column, row from the "
                  "bottom) and how many.\njoins:");
  if (map.joins.empty()) text += " []";
  text += "\n";
  for (const LevelJoin& join : map.joins) {
    const core::CellIndex middle = join.cells[join.cells.size() / 2];
    absl::StrAppendFormat(
        &text, "  - {lower: %d, upper: %d, cell: [%d, %d], cells: %d}\n",
        join.lower_level, join.upper_level, middle.x, middle.y,
        join.cells.size());
  }
  return text;
}

absl::Status WriteLevel(const TraversableMap& map, int index, double lowest_m,
                        double max_slope_rad, const std::string& stem) {
  const TraversableLevel& level = map.levels[static_cast<size_t>(index)];
  TL_RETURN_IF_ERROR(core::WriteMap(level.grid, stem + ".yaml"));
  for (const Layer& layer : LayersFrom(lowest_m)) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        absl::StrCat(stem, "-", layer.name, ".pgm"),
        core::FormatPgm(
            PictureOfLayer(level.grid, level.*layer.values, layer.scale))));
  }
  TL_ASSIGN_OR_RETURN(const std::string png, image::EncodePng(PictureOfLevel(
                                                 map, index, max_slope_rad)));
  return base::WriteFileAtomically(stem + ".png", png);
}

}  // namespace

image::ColorImage PictureOfLevel(const TraversableMap& map, int level,
                                 double max_slope_rad) {
  const TraversableLevel& shown = map.levels[static_cast<size_t>(level)];
  const core::OccupancyGrid& grid = shown.grid;
  std::vector<uint8_t> joined(grid.cells.size());
  for (const LevelJoin& join : map.joins) {
    if (join.lower_level != level && join.upper_level != level) continue;
    for (const core::CellIndex cell : join.cells)
      joined[grid.IndexOf(cell)] = 1;
  }
  image::ColorImage picture{
      .width = grid.width, .height = grid.height, .rgb = {}};
  picture.rgb.reserve(3 * grid.cells.size());
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const size_t cell = grid.IndexOf({x, y});
      const Color color = joined[cell] != 0
                              ? kJoinColor
                              : CellColor(shown, cell, max_slope_rad);
      picture.rgb.insert(picture.rgb.end(), color.begin(), color.end());
    }
  }
  return picture;
}

absl::Status WriteTraversableMap(const TraversableMap& map,
                                 double max_slope_rad,
                                 const std::string& folder) {
  const std::string layers = folder + "/layers.yaml";
  TL_RETURN_IF_ERROR(base::MakeParentFolder(layers));
  const double lowest_m = LowestHeight_m(map);
  for (size_t level = 0; level < map.levels.size(); ++level) {
    TL_RETURN_IF_ERROR(WriteLevel(map, static_cast<int>(level), lowest_m,
                                  max_slope_rad,
                                  absl::StrCat(folder, "/level-", level)));
  }
  // Last, so that it stands for a complete folder.
  return base::WriteFileAtomically(layers, DescribeLayers(map, lowest_m));
}

absl::Status TraversabilityCommand::Validate() const {
  if (octomap_path.empty()) {
    return absl::InvalidArgumentError("no OctoMap is named");
  }
  if (output_folder.empty()) {
    return absl::InvalidArgumentError("no output folder is named");
  }
  octree::OctreeReadOptions reading;
  reading.occupied_threshold = occupied_threshold;
  TL_RETURN_IF_ERROR(reading.Validate());
  return options.Validate();
}

absl::StatusOr<TraversabilitySummary> RunTraversability(
    const TraversabilityCommand& command) {
  TL_RETURN_IF_ERROR(command.Validate());
  TL_ASSIGN_OR_RETURN(
      const octree::VoxelMap voxels,
      octree::ReadOctree(command.octomap_path,
                         {.occupied_threshold = command.occupied_threshold,
                          .max_bytes = octree::VoxelMap::kDefaultMaxBytes}));
  const auto begin = std::chrono::steady_clock::now();
  const absl::StatusOr<TraversableMap> map =
      ExtractTraversableMap(voxels, command.options);
  if (!map.ok()) return base::Annotate(map.status(), command.octomap_path);
  TraversabilitySummary summary{
      .levels = static_cast<int>(map->levels.size()),
      .joins = static_cast<int>(map->joins.size()),
      .free_cells = 0,
      .occupied_cells = 0,
      .extraction_ms = std::chrono::duration<double, std::milli>(
                           std::chrono::steady_clock::now() - begin)
                           .count()};
  for (const TraversableLevel& level : map->levels) {
    const auto count = [&level](core::Occupancy value) {
      return std::count(level.grid.cells.begin(), level.grid.cells.end(),
                        value);
    };
    summary.free_cells += count(core::Occupancy::kFree);
    summary.occupied_cells += count(core::Occupancy::kOccupied);
  }
  TL_RETURN_IF_ERROR(WriteTraversableMap(*map, command.options.max_slope_rad,
                                         command.output_folder));
  return summary;
}

}  // namespace treeline::traversability

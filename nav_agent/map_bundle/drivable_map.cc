#include "nav_agent/map_bundle/drivable_map.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/doubtful_map.h"
#include "nav_agent/map_bundle/map_bundle.h"

namespace treeline::map_bundle {
namespace {

namespace fs = std::filesystem;

// Where the walls of a flat map are drawn (m). No laser minds.
constexpr double kShownHeight_m = 0.3;

bool IsFile(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

absl::StatusOr<DrivableMap> LoadFlatMap(const std::string& path) {
  TL_ASSIGN_OR_RETURN(core::DoubtfulMap file, core::ReadDoubtfulMap(path));
  if (std::ranges::find(file.grid.cells, core::Occupancy::kFree) ==
      file.grid.cells.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path,
                     ": none of its cells is free; do negate, free_thresh and "
                     "mode belong to its picture?"));
  }
  DrivableMap map = {.name = fs::path(path).stem().string(),
                     .voxels = {},
                     .levels = {},
                     .warning = std::move(file.doubt)};
  // Made without its origin: cells begin there, and it may be turned.
  const geometry::Rigid2 map_from_grid =
      std::exchange(file.grid.map_from_grid, {});
  const double floor_m = 0;
  TL_ASSIGN_OR_RETURN(map.levels, PlanarLevels({&file.grid, 1}, {&floor_m, 1}));
  TL_ASSIGN_OR_RETURN(map.voxels, PlanarVoxels(map.levels, kShownHeight_m));
  map.levels.levels.front().grid.map_from_grid = map_from_grid;
  return map;
}

// What was meant by the name of something that is no map.
std::string MeantBy(const std::string& path) {
  const std::string yaml = absl::StrCat(path, ".yaml");
  if (IsFile(yaml)) return absl::StrCat("do you mean ", yaml, "?");
  const std::string beside = fs::path(path).replace_extension("yaml").string();
  if (IsFile(path) && IsFile(beside)) {
    return absl::StrCat("a map of map_server is named by its YAML: ", beside);
  }
  for (const char* ending : {".posegraph", ".data"}) {
    if (absl::EndsWith(path, ending)) {
      return "slam_toolbox's pose graphs are not read; save the map with "
             "map_saver_cli, and name its YAML";
    }
  }
  std::error_code error;
  std::string within;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    const std::string file = entry.path().string();
    if (IsFlatMapName(file) && (within.empty() || file < within) &&
        core::ReadDoubtfulMap(file).ok()) {
      within = file;
    }
  }
  if (!within.empty()) {
    return absl::StrCat("a map of map_server is named by its YAML: ", within);
  }
  return "it must be the folder that `treeline-agent map` makes, or the YAML "
         "of a map of map_server";
}

}  // namespace

bool IsFlatMapName(absl::string_view path) {
  return absl::EndsWith(path, ".yaml") || absl::EndsWith(path, ".yml");
}

absl::StatusOr<DrivableMap> LoadDrivableMap(const std::string& path) {
  std::error_code error;
  const bool is_folder = fs::is_directory(path, error);
  if (!is_folder && IsFlatMapName(path)) return LoadFlatMap(path);
  absl::StatusOr<MapBundle> bundle = LoadMapBundle(path);
  if (absl::IsNotFound(bundle.status()) &&
      !IsFile(absl::StrCat(path, "/", kBundleManifest))) {
    return absl::NotFoundError(
        absl::StrCat("'", path, "' is no map; ", MeantBy(path)));
  }
  TL_RETURN_IF_ERROR(bundle.status());
  return DrivableMap{.name = std::move(bundle->manifest.name),
                     .voxels = std::move(bundle->voxels),
                     .levels = std::move(bundle->levels),
                     .warning = ""};
}

}  // namespace treeline::map_bundle

#include "nav_agent/map_bundle/map_bundle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/octomap/octree_file.h"

namespace treeline::map_bundle {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kVersion = 1;
constexpr int64_t kMaxParts = 10'000'000;
constexpr std::array<const char*, 6> kParts = {
    kBundleManifest,  kBundleOctomap,    kBundleLevels,
    kBundleKeyframes, kBundleTrajectory, kBundlePicture};

constexpr size_t kMaxNameBytes = 64;

bool IsSceneName(absl::string_view name) {
  return !name.empty() && name.size() <= kMaxNameBytes && name[0] != '.' &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  c == '-' || c == '_' || c == '.';
         });
}

// In YAML's double quotes.
std::string Quoted(absl::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += absl::ascii_iscntrl(static_cast<unsigned char>(c)) ? ' ' : c;
  }
  return quoted + "\"";
}

std::string FormatManifest(const MapBundleManifest& manifest) {
  const traversability::TraversabilityOptions& t = manifest.traversability;
  std::string text = absl::StrFormat(
      "# A Treeline map bundle (docs/reference/map-bundle.md). Written last: a "
      "folder\n"
      "# without this file is not complete.\n"
      "version: %d\nname: %s\nsource: %s\nmethod: %s\n",
      kVersion, manifest.name, Quoted(manifest.source),
      Quoted(manifest.method));
  absl::StrAppendFormat(&text,
                        "resolution_m: %.9g\nlevels: %d\nkeyframes: %d\n"
                        "trajectory: {of: %s, poses: %d}\n",
                        manifest.resolution_m, manifest.levels,
                        manifest.keyframes, manifest.trajectory_of,
                        manifest.poses);
  if (!manifest.planar_heights_m.empty()) {
    absl::StrAppend(&text, "planar_heights_m: [",
                    absl::StrJoin(manifest.planar_heights_m, ", "), "]\n");
  }
  absl::StrAppendFormat(
      &text,
      "# What the levels were extracted for.\ntraversability:\n"
      "  max_slope_rad: %.17g\n  max_step_m: %.17g\n  robot_height_m: %.17g\n"
      "  min_ground_width_m: %.17g\n  min_platform_area_m2: %.17g\n"
      "  max_riser_m: %.17g\n  level_overlap_m: %.17g\n",
      t.max_slope_rad, t.max_step_m, t.robot_height_m, t.min_ground_width_m,
      t.min_platform_area_m2, t.max_riser_m, t.level_overlap_m);
  return text;
}

absl::StatusOr<traversability::TraversabilityOptions> ParseTraversability(
    const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys(
      {"max_slope_rad", "max_step_m", "robot_height_m", "min_ground_width_m",
       "min_platform_area_m2", "max_riser_m", "level_overlap_m"}));
  traversability::TraversabilityOptions options;
  const std::array<std::pair<const char*, double*>, 7> fields = {
      {{"max_slope_rad", &options.max_slope_rad},
       {"max_step_m", &options.max_step_m},
       {"robot_height_m", &options.robot_height_m},
       {"min_ground_width_m", &options.min_ground_width_m},
       {"min_platform_area_m2", &options.min_platform_area_m2},
       {"max_riser_m", &options.max_riser_m},
       {"level_overlap_m", &options.level_overlap_m}}};
  for (const auto& [key, value] : fields) {
    TL_ASSIGN_OR_RETURN(*value, node.Number(key, 0, 1e6));
  }
  const absl::Status valid = options.Validate();
  if (!valid.ok()) return node.Error(valid.message());
  return options;
}

bool Exists(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error);
}

absl::Status CheckParts(const std::string& folder,
                        const MapBundleManifest& manifest) {
  const auto check = [&folder](const std::string& part) {
    if (Exists(folder + "/" + part)) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrCat(folder, ": this map bundle lacks ", part,
                     "; make it anew with `treeline-agent map`"));
  };
  TL_RETURN_IF_ERROR(check(kBundleOctomap));
  TL_RETURN_IF_ERROR(check(kBundleTrajectory));
  for (int level = 0; level < manifest.levels; ++level) {
    TL_RETURN_IF_ERROR(
        check(absl::StrCat(kBundleLevels, "/level-", level, ".yaml")));
  }
  return manifest.keyframes > 0 ? check(kBundleKeyframes) : absl::OkStatus();
}

std::string LevelPath(const std::string& folder, size_t level) {
  return absl::StrCat(folder, "/", kBundleLevels, "/level-", level, ".yaml");
}

absl::StatusOr<std::vector<core::OccupancyGrid>> ReadLevels(
    const std::string& folder, int count) {
  std::vector<core::OccupancyGrid> grids;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    TL_ASSIGN_OR_RETURN(grids.emplace_back(),
                        core::ReadMap(LevelPath(folder, i)));
  }
  return grids;
}

// The same voxels in the box of the levels' cells: a file of voxels leaves out
// what is unknown around them, and planar levels are drawn with it.
absl::StatusOr<octree::VoxelMap> WithCellsOf(
    const traversability::TraversableMap& levels,
    const octree::VoxelMap& voxels) {
  const core::OccupancyGrid& grid = levels.levels[0].grid;
  const double resolution_m = voxels.resolution_m();
  const geometry::Vec2 corner = grid.map_from_grid.translation;
  const octree::VoxelIndex old = voxels.lowest();
  const octree::VoxelIndex lowest = {
      static_cast<int>(std::lround(corner.x / resolution_m)),
      static_cast<int>(std::lround(corner.y / resolution_m)), old.z};
  TL_ASSIGN_OR_RETURN(
      octree::VoxelMap made,
      octree::VoxelMap::Make(resolution_m, lowest,
                             {grid.width, grid.height, voxels.size().z}));
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      for (int z = 0; z < voxels.size().z; ++z) {
        const octree::Voxel voxel =
            voxels.At({x + lowest.x - old.x, y + lowest.y - old.y, z});
        if (voxel != octree::Voxel::kUnknown) made.Set({x, y, z}, voxel);
      }
    }
  }
  return made;
}

}  // namespace

absl::Status CheckBundleName(absl::string_view name) {
  if (IsSceneName(name)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "'", name, "' is no name for a scene: letters, digits, '-', '_' and '.'",
      ", at most ", kMaxNameBytes, " and no '.' in front"));
}

absl::Status BeginMapBundle(const std::string& folder, bool overwrite) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("making ", folder, ": ", error.message()));
  }
  if (overwrite) {
    for (const char* part : kParts) {
      fs::remove_all(folder + "/" + part, error);
      if (error) {
        return absl::UnavailableError(absl::StrCat(
            "removing ", folder, "/", part, ": ", error.message()));
      }
    }
    return absl::OkStatus();
  }
  for (const char* part : kParts) {
    if (Exists(folder + "/" + part)) {
      return absl::AlreadyExistsError(absl::StrCat(
          folder, ": there is a map already (", part,
          "); name another folder, or replace it with --overwrite"));
    }
  }
  return absl::OkStatus();
}

absl::Status WriteBundleTrajectory(
    const std::string& folder, std::span<const dataset::TimedPose> trajectory) {
  return base::WriteFileAtomically(folder + "/" + kBundleTrajectory,
                                   dataset::FormatTimedPoses(trajectory));
}

absl::Status FinishMapBundle(const std::string& folder,
                             const MapBundleManifest& manifest) {
  TL_RETURN_IF_ERROR(CheckBundleName(manifest.name));
  TL_RETURN_IF_ERROR(CheckParts(folder, manifest));
  return base::WriteFileAtomically(folder + "/" + kBundleManifest,
                                   FormatManifest(manifest));
}

absl::StatusOr<MapBundleManifest> ParseMapBundleManifest(
    absl::string_view yaml, absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root,
                      yaml::YamlNode::Parse(yaml, name));
  TL_RETURN_IF_ERROR(root.CheckKeys(
      {"version", "name", "source", "method", "resolution_m", "levels",
       "keyframes", "trajectory", "planar_heights_m", "traversability"}));
  TL_ASSIGN_OR_RETURN(const int64_t version,
                      root.Integer("version", 1, 1'000'000));
  if (version != kVersion) {
    return root.Error(absl::StrCat("version ", version,
                                   " of map bundles is not known; this "
                                   "program reads version ",
                                   kVersion));
  }
  MapBundleManifest manifest;
  TL_ASSIGN_OR_RETURN(manifest.name, root.Text("name"));
  if (!IsSceneName(manifest.name)) {
    return root.Error("name must be of letters, digits, '-', '_' and '.'");
  }
  TL_ASSIGN_OR_RETURN(manifest.source, root.TextOr("source", ""));
  TL_ASSIGN_OR_RETURN(manifest.method, root.TextOr("method", ""));
  TL_ASSIGN_OR_RETURN(manifest.resolution_m,
                      root.Number("resolution_m", 0.001, 10));
  TL_ASSIGN_OR_RETURN(const int64_t levels, root.Integer("levels", 0, 1000));
  TL_ASSIGN_OR_RETURN(const int64_t keyframes,
                      root.Integer("keyframes", 0, kMaxParts));
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode trajectory, root.Get("trajectory"));
  TL_RETURN_IF_ERROR(trajectory.CheckKeys({"of", "poses"}));
  TL_ASSIGN_OR_RETURN(const int of,
                      trajectory.Choice("of", {"base", "camera"}));
  TL_ASSIGN_OR_RETURN(const int64_t poses,
                      trajectory.Integer("poses", 0, kMaxParts));
  manifest.levels = static_cast<int>(levels);
  manifest.keyframes = static_cast<int>(keyframes);
  manifest.trajectory_of = of == 0 ? "base" : "camera";
  manifest.poses = static_cast<int>(poses);
  if (root.Has("planar_heights_m")) {
    TL_ASSIGN_OR_RETURN(manifest.planar_heights_m,
                        root.Numbers("planar_heights_m",
                                     static_cast<size_t>(levels), -1e6, 1e6));
  }
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode traversability,
                      root.Get("traversability"));
  TL_ASSIGN_OR_RETURN(manifest.traversability,
                      ParseTraversability(traversability));
  return manifest;
}

absl::StatusOr<MapBundleManifest> ReadMapBundleManifest(
    const std::string& folder) {
  const std::string path = folder + "/" + kBundleManifest;
  if (!Exists(path)) {
    if (Exists(folder + "/" + kBundleOctomap) ||
        Exists(folder + "/" + kBundleKeyframes)) {
      return absl::FailedPreconditionError(
          absl::StrCat(folder,
                       ": this map bundle is not complete, mapping was "
                       "interrupted; make it anew with `treeline-agent map`"));
    }
    return absl::NotFoundError(absl::StrCat(
        folder, ": there is no map bundle; `treeline-agent map` makes one"));
  }
  TL_ASSIGN_OR_RETURN(const std::string yaml,
                      base::ReadFile(path, yaml::YamlNode::kMaxBytes));
  TL_ASSIGN_OR_RETURN(MapBundleManifest manifest,
                      ParseMapBundleManifest(yaml, path));
  TL_RETURN_IF_ERROR(CheckParts(folder, manifest));
  return manifest;
}

absl::StatusOr<MapBundle> LoadMapBundle(const std::string& folder) {
  MapBundle bundle;
  TL_ASSIGN_OR_RETURN(bundle.manifest, ReadMapBundleManifest(folder));
  const std::string octomap = folder + "/" + kBundleOctomap;
  TL_ASSIGN_OR_RETURN(bundle.voxels, octree::ReadOctree(octomap));
  TL_ASSIGN_OR_RETURN(std::vector<core::OccupancyGrid> drawn,
                      ReadLevels(folder, bundle.manifest.levels));
  if (!bundle.manifest.planar_heights_m.empty()) {
    TL_ASSIGN_OR_RETURN(bundle.levels,
                        PlanarLevels(drawn, bundle.manifest.planar_heights_m));
    TL_ASSIGN_OR_RETURN(bundle.voxels,
                        WithCellsOf(bundle.levels, bundle.voxels));
    return bundle;
  }
  absl::StatusOr<traversability::TraversableMap> levels =
      traversability::ExtractTraversableMap(bundle.voxels,
                                            bundle.manifest.traversability);
  if (!levels.ok()) return base::Annotate(levels.status(), octomap);
  bundle.levels = *std::move(levels);
  if (bundle.levels.levels.size() != drawn.size()) {
    return absl::FailedPreconditionError(
        absl::StrCat(folder, ": the OctoMap has ", bundle.levels.levels.size(),
                     " levels, bundle.yaml says ", drawn.size()));
  }
  for (size_t i = 0; i < drawn.size(); ++i) {
    core::OccupancyGrid& grid = bundle.levels.levels[i].grid;
    if (drawn[i].width != grid.width || drawn[i].height != grid.height) {
      return absl::FailedPreconditionError(
          absl::StrFormat("%s: it is %d x %d cells large, the OctoMap %d x %d",
                          LevelPath(folder, i), drawn[i].width, drawn[i].height,
                          grid.width, grid.height));
    }
    grid.cells = std::move(drawn[i].cells);
  }
  return bundle;
}

absl::StatusOr<traversability::TraversableMap> PlanarLevels(
    std::span<const core::OccupancyGrid> grids,
    std::span<const double> heights_m) {
  if (grids.empty() || grids.size() != heights_m.size()) {
    return absl::InvalidArgumentError(
        "a planar map needs a grid and a height for each level");
  }
  const double resolution_m = grids[0].resolution_m;
  // Cells of all grids, numbered from the map's origin.
  std::vector<core::CellIndex> lowest;
  core::CellIndex low{std::numeric_limits<int>::max(),
                      std::numeric_limits<int>::max()};
  core::CellIndex high{std::numeric_limits<int>::min(),
                       std::numeric_limits<int>::min()};
  for (const core::OccupancyGrid& grid : grids) {
    if (grid.resolution_m != resolution_m || grid.map_from_grid.yaw_rad != 0) {
      return absl::InvalidArgumentError(
          "the levels' grids differ in resolution, or are turned");
    }
    const geometry::Vec2 corner = grid.map_from_grid.translation;
    lowest.push_back({static_cast<int>(std::lround(corner.x / resolution_m)),
                      static_cast<int>(std::lround(corner.y / resolution_m))});
    low = {std::min(low.x, lowest.back().x), std::min(low.y, lowest.back().y)};
    high = {std::max(high.x, lowest.back().x + grid.width),
            std::max(high.y, lowest.back().y + grid.height)};
  }
  traversability::TraversableMap map;
  for (size_t i = 0; i < grids.size(); ++i) {
    traversability::TraversableLevel level;
    level.grid = core::OccupancyGrid::Filled(
        high.x - low.x, high.y - low.y, resolution_m,
        {.translation = {low.x * resolution_m, low.y * resolution_m}},
        core::Occupancy::kUnknown);
    for (int y = 0; y < grids[i].height; ++y) {
      for (int x = 0; x < grids[i].width; ++x) {
        level.grid.Set({x + lowest[i].x - low.x, y + lowest[i].y - low.y},
                       grids[i].At({x, y}));
      }
    }
    const size_t cells = level.grid.cells.size();
    level.height_m.assign(cells, static_cast<float>(heights_m[i]));
    level.slope_rad.assign(cells, 0);
    level.clearance_m.assign(cells, std::numeric_limits<float>::infinity());
    map.levels.push_back(std::move(level));
  }
  return map;
}

absl::StatusOr<octree::VoxelMap> PlanarVoxels(
    const traversability::TraversableMap& levels, double laser_height_m) {
  if (levels.levels.empty()) {
    return absl::InvalidArgumentError("there is no level");
  }
  const core::OccupancyGrid& first = levels.levels[0].grid;
  const double resolution_m = first.resolution_m;
  const auto layer_of = [&](const traversability::TraversableLevel& level) {
    return static_cast<int>(
        std::floor((level.height_m[0] + laser_height_m) / resolution_m));
  };
  const geometry::Vec2 corner = first.map_from_grid.translation;
  const octree::VoxelIndex lowest = {
      static_cast<int>(std::lround(corner.x / resolution_m)),
      static_cast<int>(std::lround(corner.y / resolution_m)),
      layer_of(levels.levels.front())};
  const octree::VoxelIndex size = {
      first.width, first.height, layer_of(levels.levels.back()) - lowest.z + 1};
  TL_ASSIGN_OR_RETURN(octree::VoxelMap map,
                      octree::VoxelMap::Make(resolution_m, lowest, size));
  for (const traversability::TraversableLevel& level : levels.levels) {
    const int z = layer_of(level) - lowest.z;
    for (int y = 0; y < first.height; ++y) {
      for (int x = 0; x < first.width; ++x) {
        const core::Occupancy cell = level.grid.At({x, y});
        if (cell == core::Occupancy::kUnknown) continue;
        map.Set({x, y, z}, cell == core::Occupancy::kOccupied
                               ? octree::Voxel::kOccupied
                               : octree::Voxel::kFree);
      }
    }
  }
  return map;
}

}  // namespace treeline::map_bundle

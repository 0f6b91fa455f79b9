// A map bundle: what one drive leaves behind. Where a robot may go (OctoMap and
// traversable levels), and where it is (keyframes that a scene's forest is
// trained on). docs/reference/map-bundle.md specifies the folder.
#ifndef NAV_AGENT_MAP_BUNDLE_MAP_BUNDLE_H_
#define NAV_AGENT_MAP_BUNDLE_MAP_BUNDLE_H_

#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/dataset/text_formats.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::map_bundle {

// What bundle.yaml says.
struct MapBundleManifest {
  // Of the scene, as a server will call it: letters, digits, "-", "_" and ".".
  std::string name{};
  // The file or recording that it was made of, and how, as text for people.
  std::string source{};
  std::string method{};
  // Whose poses trajectory.txt holds: "base" or "camera".
  std::string trajectory_of = "base";
  int poses = 0;
  int keyframes = 0;
  int levels = 0;
  double resolution_m = 0.05;
  // Of a map that was made without a camera: the ground's height on each level.
  // The OctoMap then is what a horizontal plane through the laser saw, and
  // levels are what their pictures say. Empty: the OctoMap has ground.
  std::vector<double> planar_heights_m{};
  // What the levels were extracted for.
  traversability::TraversabilityOptions traversability{};
};

// The parts, relative to the bundle's folder.
inline constexpr char kBundleManifest[] = "bundle.yaml";
inline constexpr char kBundleOctomap[] = "octomap.bt";
inline constexpr char kBundleLevels[] = "levels";
inline constexpr char kBundleKeyframes[] = "keyframes";
inline constexpr char kBundleTrajectory[] = "trajectory.txt";
inline constexpr char kBundlePicture[] = "map.png";

// One level for each grid, without slopes or joins. The grids may differ in
// size and place; the levels' cover all of them. INVALID_ARGUMENT if there is
// none, they differ in resolution, or are turned.
absl::StatusOr<traversability::TraversableMap> PlanarLevels(
    std::span<const core::OccupancyGrid> grids,
    std::span<const double> heights_m);

// What a horizontal plane `laser_height_m` above each level's ground saw: a
// layer of voxels.
absl::StatusOr<octree::VoxelMap> PlanarVoxels(
    const traversability::TraversableMap& levels, double laser_height_m);

// INVALID_ARGUMENT: a manifest may not have that name.
absl::Status CheckBundleName(absl::string_view name);

// Makes the folder ready for a new bundle. ALREADY_EXISTS if there is something
// in it, unless `overwrite`: then what a bundle consists of is removed, and
// nothing else.
absl::Status BeginMapBundle(const std::string& folder, bool overwrite);

// Writes trajectory.txt (TUM: "time tx ty tz qx qy qz qw").
absl::Status WriteBundleTrajectory(
    const std::string& folder, std::span<const dataset::TimedPose> trajectory);

// The last step: a folder without it is not complete.
absl::Status FinishMapBundle(const std::string& folder,
                             const MapBundleManifest& manifest);

// NOT_FOUND: there is no such folder, or no bundle in it. FAILED_PRECONDITION:
// it is not complete, because mapping was interrupted, or a part was removed.
// INVALID_ARGUMENT, with file and line: bundle.yaml is not one.
absl::StatusOr<MapBundleManifest> ReadMapBundleManifest(
    const std::string& folder);
// Safe on any bytes.
absl::StatusOr<MapBundleManifest> ParseMapBundleManifest(
    absl::string_view yaml, absl::string_view name);

struct MapBundle {
  MapBundleManifest manifest;
  octree::VoxelMap voxels;
  // Extracted from the OctoMap (if it has ground), and then as level-N.pgm has
  // it: somebody may have drawn in it where the robot must not go.
  traversability::TraversableMap levels;
};

// The errors of ReadMapBundleManifest and of the parts. FAILED_PRECONDITION if
// a level's picture is not of the OctoMap's cells.
absl::StatusOr<MapBundle> LoadMapBundle(const std::string& folder);

}  // namespace treeline::map_bundle

#endif  // NAV_AGENT_MAP_BUNDLE_MAP_BUNDLE_H_

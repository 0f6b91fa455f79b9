// Puts a map bundle together from views with known poses.
#ifndef NAV_AGENT_APP_MAP_MAP_ASSEMBLY_H_
#define NAV_AGENT_APP_MAP_MAP_ASSEMBLY_H_

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/text_formats.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/fusion/octomap_builder.h"
#include "nav_agent/map_bundle/keyframe_files.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "nav_agent/traversability/traversability_options.h"

namespace treeline::map_app {

// What every way of making a map is told.
struct MapOptions {
  // Of the bundle; what it may replace, see BeginMapBundle.
  std::string folder;
  bool overwrite = false;
  // Of the scene; empty: the folder's own name.
  std::string name;
  fusion::FusionOptions fusion;
  traversability::TraversabilityOptions traversability;
  // Leaves in the map what moved while it was made.
  bool keep_moved = false;
  // A frame becomes a keyframe when the camera has moved so far since the last
  // one (m, rad). As many as possible are kept (thesis 6.3.1); nearer ones tell
  // a forest nothing new.
  double keyframe_m = 0.05;
  double keyframe_rad = 0.04;
  // The same for the laser's scans.
  double scan_m = 0.2;
  double scan_rad = 0.2;
  uint64_t seed = 0;

  absl::Status Validate() const;
  // Of the scene: "maps/cafe/" is called cafe.
  std::string SceneName() const;
};

struct MapSummary {
  std::string folder;
  int keyframes = 0;
  int levels = 0;
  int joins = 0;
  int64_t free_cells = 0;
  int64_t occupied_voxels = 0;
  int64_t free_voxels = 0;
  // Columns of the map that the wheels stood in and no view had kept ground of.
  int driven_holes = 0;
  // Voxels of what moved, which became free.
  int64_t moved_voxels = 0;
};

// Where the map was made from: text and poses that end up in the bundle.
struct MapProvenance {
  std::string source;
  std::string method;
  std::string trajectory_of = "base";
  std::vector<dataset::TimedPose> trajectory;
  // Of a robot whose base the trajectory is of, to the outer edge of its
  // wheels. What they stood on is ground.
  std::optional<double> half_width_m = {};
};

// Whether something has moved far enough since the last time that it had.
class MotionGate {
 public:
  MotionGate(double distance_m, double turn_rad)
      : distance_m_(distance_m), turn_rad_(turn_rad) {}
  bool Passes(const geometry::Rigid3& map_from_sensor);

 private:
  double distance_m_;
  double turn_rad_;
  std::optional<geometry::Rigid3> last_;
};

// Not thread-safe.
class MapAssembly {
 public:
  // Begins the bundle. Errors are those of BeginMapBundle and of the options.
  static absl::StatusOr<std::unique_ptr<MapAssembly>> Begin(
      const MapOptions& options);

  // Before the first keyframe.
  absl::Status SetCamera(const camera::RgbdCalibration& calibration);
  // A keyframe: its depth goes into the OctoMap, its files into the sequence.
  // map_from_camera: of the calibration's pose sensor.
  absl::Status AddKeyframe(absl::string_view color, absl::string_view depth,
                           double depth_unit_m,
                           const geometry::Rigid3& map_from_camera);
  // Ends of a laser's beams (m), in its frame.
  absl::Status AddPoints(std::span<const geometry::Vec3> points_in_laser,
                         const geometry::Rigid3& map_from_laser);

  int keyframes() const;
  const fusion::OctomapBuilder& octomap() const { return octomap_; }

  // Extracts the levels and writes what is not written yet.
  // FAILED_PRECONDITION if nothing was seen, or no ground.
  absl::StatusOr<MapSummary> Finish(const MapProvenance& provenance);
  // Instead, for a laser alone: one level for each grid.
  absl::StatusOr<MapSummary> FinishPlanar(
      const MapProvenance& provenance,
      std::span<const core::OccupancyGrid> grids,
      std::span<const double> heights_m, double laser_height_m);

 private:
  MapAssembly(const MapOptions& options, fusion::OctomapBuilder octomap);
  absl::StatusOr<MapSummary> Write(const MapProvenance& provenance,
                                   const octree::VoxelMap& voxels,
                                   const traversability::TraversableMap& levels,
                                   std::vector<double> planar_heights_m);

  MapOptions options_;
  fusion::OctomapBuilder octomap_;
  camera::RgbdCalibration calibration_;
  std::optional<map_bundle::KeyframeWriter> keyframes_;
  int64_t views_ = 0;
};

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_MAP_ASSEMBLY_H_

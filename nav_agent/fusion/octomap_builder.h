// Depth views in, an OctoMap out (thesis 6.3.1).
#ifndef NAV_AGENT_FUSION_OCTOMAP_BUILDER_H_
#define NAV_AGENT_FUSION_OCTOMAP_BUILDER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"
#include "nav_agent/fusion/compact_cloud.h"
#include "nav_agent/fusion/fusion_options.h"
#include "nav_agent/fusion/occupancy_blocks.h"
#include "nav_agent/fusion/view_grid.h"
#include "nav_agent/octomap/voxel_map.h"

namespace treeline::fusion {

// Where a view was taken from.
struct ViewPose {
  int64_t id = 0;
  geometry::Rigid3 map_from_sensor;
};

// What a builder takes (bytes). During SetPoses there are two maps.
struct FusionMemory {
  int64_t map = 0;
  int64_t clouds = 0;
  int64_t working = 0;

  int64_t total() const { return map + clouds + working; }
};

// Each view becomes a small cloud (see compact_cloud.h). Its points are hits,
// and every voxel between the sensor and a point is a miss; of points in one
// voxel only the first one's ray is cast. Each voxel counts once per view, as a
// hit if it is both. Hits and misses are added up as log-odds, clamped, as
// OctoMap does; so what has moved away is cleared by later views. Clouds are
// kept, so that after a loop closure the map can be made anew.
//
// Deterministic. Not thread-safe. Every error leaves all as it was.
class OctomapBuilder {
 public:
  // INVALID_ARGUMENT for options out of range.
  static absl::StatusOr<OctomapBuilder> Make(const FusionOptions& options = {});

  // Adds a view under an id of its own. INVALID_ARGUMENT: image and camera do
  // not fit, a pose that is not finite or not a rotation (its quaternion's norm
  // is further than 1e-3 from 1), or so far away that the view does not lie
  // within 2^15 voxels of the map's origin; ALREADY_EXISTS: the id;
  // RESOURCE_EXHAUSTED: max_bytes. A view without any depth is no error.
  absl::Status InsertDepth(int64_t id, const image::DepthImage& depth,
                           const camera::Camera& camera,
                           const geometry::Rigid3& map_from_camera);
  // The same for points in a sensor's frame (m), seen from its origin, such as
  // those of a laser scan. Points that are not finite are left out. Their rays
  // clear nothing that depth has shown.
  absl::Status InsertPoints(int64_t id,
                            std::span<const geometry::Vec3> points_in_sensor,
                            const geometry::Rigid3& map_from_sensor);

  // Moves views and makes the map anew: exactly the map that inserting all
  // views, in the order in which they came, with their poses of now makes.
  // Views that are not named keep their pose. NOT_FOUND: an id; else as above.
  absl::Status SetPoses(std::span<const ViewPose> poses);

  // Makes free what is occupied and has moved (moved_voxels.h). For when all
  // views have come: what is inserted later adds to that, and SetPoses makes
  // the map as if this had not been called. Returns how many voxels. Takes 8
  // bytes an occupied voxel meanwhile, and as long as SetPoses.
  // RESOURCE_EXHAUSTED: max_bytes.
  absl::StatusOr<int64_t> ForgetMoved();

  // Occupied is what the threshold says, free what else is known. The box is
  // that of the known blocks of 8 voxels, widened in x and y to multiples of
  // `alignment` (at least 1) voxels, so that it seldom changes while a map
  // grows. RESOURCE_EXHAUSTED as VoxelMap::Make.
  absl::StatusOr<octree::VoxelMap> Map(int alignment = 1) const;
  // The bytes of an .ot file with the log-odds as they are.
  absl::StatusOr<std::string> FormatOt() const;

  // The columns in which a voxel has become known, occupied or free, or ceased
  // to be, since the last call; nullopt: none. In a VoxelMap `map`, subtract
  // map.lowest().
  std::optional<ColumnBox> TakeChangedColumns();

  const FusionOptions& options() const { return options_; }
  int64_t views() const { return static_cast<int64_t>(views_.size()); }
  FusionMemory memory() const;

 private:
  struct View {
    ViewPose pose;
    ViewKind kind = ViewKind::kSurfaces;
    CompactCloud cloud;
  };

  explicit OctomapBuilder(const FusionOptions& options)
      : options_(options), map_(options) {}

  absl::Status Insert(int64_t id, ViewKind kind, CompactCloud cloud,
                      const geometry::Rigid3& map_from_sensor);
  // Marks in grid_ what a cloud's rays meet and pass. Returns the sensor's
  // place in the grid.
  absl::StatusOr<geometry::Vec3> Trace(const CompactCloud& cloud,
                                       const geometry::Rigid3& map_from_sensor);
  // What tracing the cloud in places_ takes with a grid of so many blocks.
  int64_t WorkingBytes(octree::VoxelIndex blocks) const;
  // Adds a cloud to `map`.
  absl::StatusOr<std::optional<ColumnBox>> Fuse(
      const CompactCloud& cloud, ViewKind kind,
      const geometry::Rigid3& map_from_sensor, OccupancyBlocks& map);

  FusionOptions options_;
  OccupancyBlocks map_;
  std::vector<View> views_;
  absl::flat_hash_map<int64_t, size_t> view_of_id_;
  int64_t cloud_bytes_ = 0;
  std::optional<ColumnBox> changed_;
  // Working space of Fuse.
  ViewGrid grid_;
  std::vector<geometry::Vec3> places_;
};

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_OCTOMAP_BUILDER_H_

// What a fused map should hold: the surfaces of a synthetic world, as far as a
// camera has seen them.
#ifndef TESTS_FUSION_SURFACE_TRUTH_H_
#define TESTS_FUSION_SURFACE_TRUTH_H_

#include <cstdint>
#include <utility>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"
#include "nav_agent/octomap/voxel_map.h"
#include "simulation/renderer/ray_caster.h"
#include "simulation/worlds/world.h"

namespace treeline {

struct FusionScore {
  // Occupied voxels of the map, and how many of them lie within one voxel (of
  // the 26 around) of a surface that was observed.
  int64_t occupied = 0;
  int64_t right = 0;
  // Voxels with observed surface, and how many have an occupied voxel within
  // one voxel.
  int64_t observed = 0;
  int64_t found = 0;
  // Of those whose surface looks up or down (within 45 degrees), and of those
  // with an occupied voxel within one voxel above or below: what a map of the
  // ground needs.
  int64_t observed_ground = 0;
  int64_t found_ground = 0;

  double precision() const {
    return static_cast<double>(right) / static_cast<double>(occupied);
  }
  double recall() const {
    return static_cast<double>(found) / static_cast<double>(observed);
  }
  double ground_recall() const {
    return static_cast<double>(found_ground) /
           static_cast<double>(observed_ground);
  }
};

// A surface is observed where the ray of a measured pixel truly meets something
// that never moves within the range, and the measurement is of that: within
// 0.1 m + 0.02 / m * z^2 of it, five deviations of the sensor's noise and more.
// Not thread-safe.
class SurfaceTruth {
 public:
  // resolution_m is that of the maps. `world` must outlive it.
  static absl::StatusOr<SurfaceTruth> Make(const worlds::World& world,
                                           double resolution_m);

  // Of every pixel_step-th pixel each way.
  void Observe(const image::DepthImage& measured, const camera::Camera& camera,
               const geometry::Rigid3& world_from_camera, double max_depth_m,
               int pixel_step);

  // The map's frame must be the world's, and its resolution this one's.
  FusionScore Score(const octree::VoxelMap& map) const;
  // Whether observed surface lies within one voxel; numbered as in a map whose
  // lowest() is 0.
  bool IsNearSurface(octree::VoxelIndex voxel) const;

 private:
  SurfaceTruth(const worlds::World& world, renderer::RayCaster caster,
               octree::VoxelMap surface)
      : world_(&world),
        caster_(std::move(caster)),
        observed_(surface),
        ground_(surface),
        surface_(std::move(surface)) {}

  const worlds::World* world_;
  renderer::RayCaster caster_;
  // Within the range; what of it is ground; and a little beyond, which noise
  // may bring nearer.
  octree::VoxelMap observed_;
  octree::VoxelMap ground_;
  octree::VoxelMap surface_;
};

}  // namespace treeline

#endif  // TESTS_FUSION_SURFACE_TRUTH_H_

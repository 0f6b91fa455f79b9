// The inner loops of PointSolver: many points at once, in single precision.
#ifndef SERVER_CORE_POSE_POINT_KERNELS_H_
#define SERVER_CORE_POSE_POINT_KERNELS_H_

#include <cstddef>

#include "common/geometry/kabsch.h"
#include "common/geometry/rigid3.h"
#include "server/core/pose/truncated_cost.h"

namespace treeline::pose {

// The widest vector.
inline constexpr size_t kPairPadding = 16;

// Points in a camera, and where each is thought to be in the world.
struct PackedPairs {
  PackedVectors in_camera;
  PackedVectors in_world;

  void Reserve(size_t pairs);
  void Add(geometry::Vec3 point_in_camera, geometry::Vec3 point_in_world);
  // After the last one, before any use: adds kPairPadding pairs that do not
  // count, so that whole vectors can be read.
  void Pad();
};

// Sum over pairs [begin, end) of min(1, distance^2 / inlier_distance_m^2) with
// the distance of world_from_camera * in_camera from in_world.
double TruncatedDistances(const PackedPairs& pairs, size_t begin, size_t end,
                          const geometry::Rigid3& world_from_camera,
                          double inlier_distance_m);

// Over those of pairs [0, end) whose distance is at most inlier_distance_m; a
// is the world, b the camera. `end` is at most the number of pairs.
geometry::CorrespondenceSums SumInliers(
    const PackedPairs& pairs, size_t end,
    const geometry::Rigid3& world_from_camera, double inlier_distance_m);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_POINT_KERNELS_H_

// Voxel maps of synthetic buildings, and how right what is made of them is.
#ifndef TESTS_TRAVERSABLE_WORLDS_TESTING_WORLD_H_
#define TESTS_TRAVERSABLE_WORLDS_TESTING_WORLD_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"
#include "simulation/worlds/ground_truth.h"
#include "simulation/worlds/world.h"

namespace treeline {

// Maps lie this much higher than the world, so that a floor at 0 lies within a
// voxel and not between two.
inline constexpr double kMapLift_m = 0.02;

// All surfaces, one voxel thick; free is all space that is connected with the
// tour's start, and the rest unknown.
octree::VoxelMap VoxelizeWorld(const worlds::World& world,
                               double resolution_m = 0.05,
                               double lift_m = kMapLift_m);

// A depth camera's drive along the tour, fused as OctoMap does: log-odds of
// hits 0.85 and misses -0.4 between -2 and 3.5, occupied from 0.7 on.
struct ScanOptions {
  uint64_t seed = 1;
  double resolution_m = 0.05;
  double lift_m = kMapLift_m;
  double step_m = 0.2;  // between pictures
  int directions = 4;   // looked into at each place
  int width_px = 160;   // of 58 x 45 degrees
  double max_range_m = 4.5;
  // Standard deviation: base + square (z - 0.4 m)^2, as a Kinect's.
  double noise_base_m = 0.0012;
  double noise_square_per_m = 0.0019;
  // Of the pose of each picture, and of what it looks like over a length of
  // the drive (errors of the map itself).
  double height_noise_m = 0.005;
  double tilt_noise_rad = 0.003;
};
absl::StatusOr<octree::VoxelMap> ScanWorld(const worlds::World& world,
                                           const ScanOptions& options);

enum class Verdict : uint8_t { kNotCounted, kRight, kWrong, kDanger };

struct WorldScore {
  int64_t cells = 0;
  int64_t wrong = 0;  // dangers included
  int64_t free_but_occupied = 0;
  int64_t occupied_but_free = 0;
  int64_t unknown_but_free = 0;
  int64_t free_stairs = 0;
  // Free cells at drops of two voxels and more, and at lower ones.
  int64_t free_edges = 0;
  int64_t free_low_edges = 0;
  // |estimate - truth| of slope (deg) and clearance (m) where both are free.
  std::vector<float> slope_errors_deg;
  std::vector<float> ramp_slope_errors_deg;
  std::vector<float> clearance_errors_m;
  // By level of the truth, in its order of cells.
  std::vector<std::vector<Verdict>> verdicts;

  double RightShare() const {
    return cells == 0
               ? 0
               : 1 - static_cast<double>(wrong) / static_cast<double>(cells);
  }
};

// Cells of the truth that are known and that `voxels` has observed. Those with
// another state within one cell, or whose room is within a voxel of the needed,
// are right either way, but nothing on stairs or at the edge of a drop may be
// free.
WorldScore ScoreWorld(const worlds::GroundTruth& truth,
                      const octree::VoxelMap& voxels,
                      const traversability::TraversableMap& map,
                      double lift_m = kMapLift_m);

// The value below which `share` of `values` lie; 0 if there is none.
double Quantile(std::vector<float> values, double share);

}  // namespace treeline

#endif  // TESTS_TRAVERSABLE_WORLDS_TESTING_WORLD_H_

// Scenes of slanted blocks, voxelised exactly, and what is true of them.
#ifndef NAV_AGENT_TRAVERSABILITY_TESTING_SCENE_H_
#define NAV_AGENT_TRAVERSABILITY_TESTING_SCENE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::traversability {

enum class BlockKind : uint8_t { kGround, kStairs, kObstacle };

// A block on the rectangle |x| <= half_x, |y| <= half_y of its own frame. Its
// top rises linearly from top_begin_m at -half_x to top_end_m at half_x.
struct Block {
  BlockKind kind = BlockKind::kGround;
  geometry::Rigid2 scene_from_block;
  double half_x_m = 1;
  double half_y_m = 1;
  double top_begin_m = 0;
  double top_end_m = 0;
  // Below the top; huge for what stands on the ground.
  double thickness_m = 100;

  std::optional<double> TopAt(geometry::Vec2 point) const;
};

struct VoxelNoise {
  uint64_t seed = 1;
  double dropped = 0;  // of occupied voxels: half become free, half unknown
  double near = 0;     // of free voxels within two of a surface: occupied
  double far = 0;      // of all free voxels: occupied
};

struct Scene {
  // x, y from 0; free space up to top_m.
  double size_x_m = 6;
  double size_y_m = 6;
  double top_m = 3;
  std::vector<Block> blocks;

  // A floor at 0.013 m, so that it lies within a voxel, not between two.
  static Scene WithFloor(double size_x_m, double size_y_m);
  static constexpr double kFloor_m = 0.013;

  // From corner to corner, straight along the axes.
  void AddBox(BlockKind kind, geometry::Vec2 low, geometry::Vec2 high,
              double top_m, double thickness_m = 100);
};

// Surfaces one voxel thick; free space outside of blocks, unknown inside.
octree::VoxelMap Voxelize(const Scene& scene, const VoxelNoise& noise = {},
                          double resolution_m = 0.05);
octree::VoxelMap WithNoise(const octree::VoxelMap& exact,
                           const VoxelNoise& noise);

struct Score {
  int64_t cells = 0;
  int64_t wrong = 0;
  int free_stairs = 0;  // cells all on stairs that are free
  int free_edges = 0;   // cells that a drop of two voxels crosses, free

  double RightShare() const {
    return cells == 0
               ? 0
               : 1 - static_cast<double>(wrong) / static_cast<double>(cells);
  }
};

// Compares cells with the truth: ground between begin_z_m and end_z_m with
// robot_height_m of room is free, all else occupied. Of several such grounds in
// a column the one that the level shows is meant. Cells where something else
// begins within a voxel may be occupied or what is true in a part of them.
Score ScoreLevel(const Scene& scene, const TraversableLevel& level,
                 double robot_height_m, double begin_z_m = -1,
                 double end_z_m = 100);

// Whether free cells of `level` connect the cells that hold two points.
bool AreConnected(const core::OccupancyGrid& grid, geometry::Vec2 from,
                  geometry::Vec2 to);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_TESTING_SCENE_H_

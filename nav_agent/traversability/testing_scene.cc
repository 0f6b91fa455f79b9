#include "nav_agent/traversability/testing_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/random.h"

namespace treeline::traversability {
namespace {

constexpr int kSamples = 3;  // of a cell, each way
constexpr double kDrop_m = 0.11;
// A level shows ground if its height differs by less: two voxels.
constexpr double kShown_m = 0.1;

// What is at a point of the plane.
struct Truth {
  bool free = false;
  bool stairs = false;
  double height_m = -1;
};

struct Solid {
  double bottom_m = 0;
  double top_m = 0;
  BlockKind kind = BlockKind::kGround;
};

std::vector<Solid> SolidsAt(const Scene& scene, geometry::Vec2 point) {
  std::vector<Solid> solids;
  for (const Block& block : scene.blocks) {
    const geometry::Vec2 offset = point - block.scene_from_block.translation;
    const double reach_m = block.half_x_m + block.half_y_m;
    // Cheaper than the block's own frame, and rules out most.
    if (std::abs(offset.x) > reach_m || std::abs(offset.y) > reach_m) continue;
    if (const std::optional<double> top_m = block.TopAt(point)) {
      solids.push_back({*top_m - block.thickness_m, *top_m, block.kind});
    }
  }
  std::sort(solids.begin(), solids.end(),
            [](const Solid& a, const Solid& b) { return a.top_m < b.top_m; });
  return solids;
}

// Where a level shows one ground of several, shown_m, that one is meant.
Truth TruthOf(const std::vector<Solid>& solids, double robot_height_m,
              double begin_z_m, double end_z_m, double shown_m) {
  Truth truth;
  bool found = false;
  for (size_t i = 0; i < solids.size(); ++i) {
    const Solid& solid = solids[i];
    if (solid.top_m < begin_z_m || solid.top_m >= end_z_m) continue;
    double room_m = 100;
    for (size_t j = i + 1; j < solids.size(); ++j) {
      room_m = std::min(room_m, solids[j].bottom_m - solid.top_m);
    }
    if (room_m <= 0) continue;  // inside of another
    const bool free =
        solid.kind == BlockKind::kGround && room_m >= robot_height_m;
    const bool shown = std::abs(solid.top_m - shown_m) < kShown_m;
    if (found && !shown && (truth.free || !free)) continue;
    truth = {.free = free,
             .stairs = solid.kind == BlockKind::kStairs,
             .height_m = solid.top_m};
    found = true;
    if (shown) break;
  }
  return truth;
}

// What the samples of a cell, and those around it, have in common.
struct TruthSpan {
  bool any_free = false;
  bool all_free = true;
  bool all_stairs = true;
  double lowest_m = 1e9;
  double highest_m = -1e9;

  void Add(const Truth& sample) {
    any_free = any_free || sample.free;
    all_free = all_free && sample.free;
    all_stairs = all_stairs && sample.stairs;
    lowest_m = std::min(lowest_m, sample.height_m);
    highest_m = std::max(highest_m, sample.height_m);
  }
};

}  // namespace

std::optional<double> Block::TopAt(geometry::Vec2 point) const {
  const geometry::Vec2 local = scene_from_block.Inverse() * point;
  if (std::abs(local.x) > half_x_m || std::abs(local.y) > half_y_m) {
    return std::nullopt;
  }
  const double part = (local.x + half_x_m) / (2 * half_x_m);
  return top_begin_m + part * (top_end_m - top_begin_m);
}

Scene Scene::WithFloor(double size_x_m, double size_y_m) {
  Scene scene{
      .size_x_m = size_x_m, .size_y_m = size_y_m, .top_m = 3, .blocks = {}};
  scene.AddBox(BlockKind::kGround, {0, 0}, {size_x_m, size_y_m}, kFloor_m);
  return scene;
}

void Scene::AddBox(BlockKind kind, geometry::Vec2 low, geometry::Vec2 high,
                   double box_top_m, double thickness_m) {
  blocks.push_back(
      {.kind = kind,
       .scene_from_block = {.translation = 0.5 * (low + high), .yaw_rad = 0},
       .half_x_m = (high.x - low.x) / 2,
       .half_y_m = (high.y - low.y) / 2,
       .top_begin_m = box_top_m,
       .top_end_m = box_top_m,
       .thickness_m = thickness_m});
}

octree::VoxelMap Voxelize(const Scene& scene, const VoxelNoise& noise,
                          double resolution_m) {
  const double r = resolution_m;
  const auto cells = [r](double length_m) {
    return static_cast<int>(std::lround(length_m / r));
  };
  constexpr int kBelow = 4;
  const int size_z = cells(scene.top_m) + kBelow;
  octree::VoxelMap map = *octree::VoxelMap::Make(
      r, {.x = 0, .y = 0, .z = -kBelow},
      {cells(scene.size_x_m), cells(scene.size_y_m), size_z});
  const auto height = static_cast<size_t>(size_z);
  for (int y = 0; y < map.size().y; ++y) {
    for (int x = 0; x < map.size().x; ++x) {
      std::vector<int> inside(height);   // samples that are all solid
      std::vector<int> touched(height);  // samples that are partly solid
      for (int sample = 0; sample < kSamples * kSamples; ++sample) {
        const geometry::Vec2 point{
            (x + (sample % kSamples + 0.5) / kSamples) * r,
            (y + (sample / kSamples + 0.5) / kSamples) * r};
        std::vector<uint8_t> solid_here(height);
        for (const Solid& solid : SolidsAt(scene, point)) {
          const double begin = solid.bottom_m / r + kBelow;
          const double end = solid.top_m / r + kBelow;
          const int low = std::max(0, static_cast<int>(std::floor(begin)));
          for (int z = low; z < std::min<double>(size_z, end); ++z) {
            uint8_t& here = solid_here[static_cast<size_t>(z)];
            // What ends between two voxels is seen in the inner one.
            here = begin < z && z + 1 < end ? 2 : std::max<uint8_t>(here, 1);
          }
        }
        for (size_t z = 0; z < height; ++z) {
          if (solid_here[z] != 0) ++touched[z];
          if (solid_here[z] == 2) ++inside[z];
        }
      }
      for (int z = 0; z < size_z; ++z) {
        const auto i = static_cast<size_t>(z);
        const octree::Voxel value = touched[i] == 0 ? octree::Voxel::kFree
                                    : inside[i] == kSamples * kSamples
                                        ? octree::Voxel::kUnknown
                                        : octree::Voxel::kOccupied;
        map.Set({x, y, z}, value);
      }
    }
  }
  return WithNoise(map, noise);
}

octree::VoxelMap WithNoise(const octree::VoxelMap& exact,
                           const VoxelNoise& noise) {
  octree::VoxelMap map = exact;
  if (noise.dropped == 0 && noise.near == 0 && noise.far == 0) return map;
  base::Random random(noise.seed, 0);
  for (int y = 0; y < map.size().y; ++y) {
    for (int x = 0; x < map.size().x; ++x) {
      for (int z = 0; z < map.size().z; ++z) {
        const double draw = random.NextUnit();
        const octree::Voxel value = exact.At({x, y, z});
        if (value == octree::Voxel::kOccupied && draw < noise.dropped) {
          map.Set({x, y, z}, draw < noise.dropped / 2
                                 ? octree::Voxel::kFree
                                 : octree::Voxel::kUnknown);
        } else if (value == octree::Voxel::kFree &&
                   draw < std::max(noise.near, noise.far)) {
          bool near = false;
          for (int dz = -2; dz <= 2; ++dz) {
            near = near || exact.At({x, y, z + dz}) == octree::Voxel::kOccupied;
          }
          if (draw < (near ? noise.near : noise.far)) {
            map.Set({x, y, z}, octree::Voxel::kOccupied);
          }
        }
      }
    }
  }
  return map;
}

Score ScoreLevel(const Scene& scene, const TraversableLevel& level,
                 double robot_height_m, double begin_z_m, double end_z_m) {
  const core::OccupancyGrid& grid = level.grid;
  const double sample_m = grid.resolution_m / kSamples;
  const int width = grid.width * kSamples;
  const int height = grid.height * kSamples;
  std::vector<std::vector<Solid>> solids;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      solids.push_back(
          SolidsAt(scene, {(x + 0.5) * sample_m, (y + 0.5) * sample_m}));
    }
  }
  Score score;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const double shown_m = level.height_m[grid.IndexOf({x, y})];
      TruthSpan own;
      TruthSpan near;
      for (int i = -kSamples; i < 2 * kSamples; ++i) {
        for (int j = -kSamples; j < 2 * kSamples; ++j) {
          const int sx = x * kSamples + i;
          const int sy = y * kSamples + j;
          if (sx < 0 || sy < 0 || sx >= width || sy >= height) continue;
          const Truth truth =
              TruthOf(solids[static_cast<size_t>(sy * width + sx)],
                      robot_height_m, begin_z_m, end_z_m, shown_m);
          near.Add(truth);
          if (std::min(i, j) >= 0 && std::max(i, j) < kSamples) own.Add(truth);
        }
      }
      if (own.lowest_m < 0) continue;  // the level ends here
      const bool free = grid.At({x, y}) == core::Occupancy::kFree;
      const bool occupied = grid.At({x, y}) == core::Occupancy::kOccupied;
      const bool boundary = near.all_free != near.any_free ||
                            near.highest_m - near.lowest_m > 0.085;
      const bool right = boundary ? occupied || (free && own.any_free)
                                  : (near.all_free ? free : occupied);
      ++score.cells;
      if (!right) ++score.wrong;
      if (free && own.all_stairs) ++score.free_stairs;
      if (free && own.highest_m - own.lowest_m > kDrop_m) ++score.free_edges;
    }
  }
  return score;
}

bool AreConnected(const core::OccupancyGrid& grid, geometry::Vec2 from,
                  geometry::Vec2 to) {
  const core::CellIndex begin = grid.CellOf(from);
  const core::CellIndex end = grid.CellOf(to);
  if (grid.AtOrUnknown(begin) != core::Occupancy::kFree) return false;
  std::vector<uint8_t> reached(grid.cells.size());
  std::vector<core::CellIndex> front = {begin};
  reached[grid.IndexOf(begin)] = 1;
  while (!front.empty()) {
    const core::CellIndex cell = front.back();
    front.pop_back();
    if (cell == end) return true;
    for (size_t d = 0; d < kNeighbors.size(); d += 2) {
      const core::CellIndex next{cell.x + kNeighbors[d].x,
                                 cell.y + kNeighbors[d].y};
      if (grid.AtOrUnknown(next) != core::Occupancy::kFree ||
          reached[grid.IndexOf(next)] != 0) {
        continue;
      }
      reached[grid.IndexOf(next)] = 1;
      front.push_back(next);
    }
  }
  return false;
}

}  // namespace treeline::traversability

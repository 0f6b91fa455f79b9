// The cost of traversable maps. scripts and figures:
// docs/research/traversability.md.
#include "benchmark/benchmark.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/traversability/testing_scene.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::traversability {
namespace {

// 13 x 10 x 3 m with walls, a platform with ramp and stairs, and tables; with
// the noise of the tests.
octree::VoxelMap MakeHall() {
  Scene scene = Scene::WithFloor(13, 10);
  for (const double x : {0.0, 12.88}) {
    scene.AddBox(BlockKind::kObstacle, {x, 0}, {x + 0.12, 10}, 2.9);
  }
  for (const double y : {0.0, 9.88}) {
    scene.AddBox(BlockKind::kObstacle, {0, y}, {13, y + 0.12}, 2.9);
  }
  scene.AddBox(BlockKind::kGround, {8.6, 4}, {13, 10}, 0.6);
  scene.blocks.push_back(
      {.kind = BlockKind::kGround,
       .scene_from_block = {.translation = {6.2, 8}, .yaw_rad = 0},
       .half_x_m = 2.4,
       .half_y_m = 0.8,
       .top_begin_m = Scene::kFloor_m,
       .top_end_m = 0.6});
  for (int i = 0; i < 3; ++i) {
    scene.AddBox(BlockKind::kStairs, {7.7 + 0.3 * i, 5}, {8.6, 6.5},
                 0.15 * (i + 1));
  }
  for (int i = 0; i < 12; ++i) {
    const geometry::Vec2 corner{1.0 + 1.7 * (i % 4),
                                1.0 + 1.6 * static_cast<int>(i / 4)};
    scene.AddBox(BlockKind::kObstacle, corner,
                 corner + geometry::Vec2{0.8, 0.8}, 0.74, 0.04);
  }
  return Voxelize(scene,
                  {.seed = 1, .dropped = 0.05, .near = 0.005, .far = 1e-4});
}

const octree::VoxelMap& Hall() {
  static const octree::VoxelMap hall = MakeHall();
  return hall;
}

void BM_FullExtraction(benchmark::State& state) {
  const octree::VoxelMap& hall = Hall();
  for (auto _ : state) {
    benchmark::DoNotOptimize(ExtractTraversableMap(hall)->levels.size());
  }
}
BENCHMARK(BM_FullExtraction)->Unit(benchmark::kMillisecond);

// 1 x 1 m in the middle of the floor.
void BM_IncrementalUpdate(benchmark::State& state) {
  const octree::VoxelMap& hall = Hall();
  absl::StatusOr<TraversabilityMapper> mapper =
      TraversabilityMapper::Make(TraversabilityOptions());
  if (!mapper->Rebuild(hall).ok()) state.SkipWithError("no map");
  for (auto _ : state) {
    if (!mapper->Update(hall, {120, 90, 140, 110}).ok()) {
      state.SkipWithError("no update");
    }
  }
}
BENCHMARK(BM_IncrementalUpdate)->Unit(benchmark::kMillisecond);

void BM_ReadBt(benchmark::State& state) {
  const std::string bytes = *octree::FormatBt(Hall());
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        octree::ParseOctree(bytes, "hall.bt")->CountOccupied());
  }
}
BENCHMARK(BM_ReadBt)->Unit(benchmark::kMillisecond);

void BM_WriteBt(benchmark::State& state) {
  const octree::VoxelMap& hall = Hall();
  for (auto _ : state) benchmark::DoNotOptimize(octree::FormatBt(hall)->size());
}
BENCHMARK(BM_WriteBt)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::traversability

BENCHMARK_MAIN();

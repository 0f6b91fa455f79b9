// The cost of one scan: 180 beams in a room, against a running window.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "nav_agent/mapping/scan_matcher.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

struct Scene {
  std::vector<ScanOutline> window;
  std::vector<PlacedScan> references;
  ScanOutline scan;
  geometry::Rigid2 truth = {{0.6, 0.1}, 0.15};

  // beams over 180 degrees, and `scans` before the one to match.
  Scene(int beams, int scans) {
    std::vector<TestWall> walls;
    AddBox({-8, -6}, {8, 6}, &walls);
    for (int i = 0; i < 6; ++i) {
      const geometry::Vec2 low = {-6.0 + 2.2 * i, i % 2 == 0 ? 3.0 : -4.0};
      AddBox(low, low + geometry::Vec2{0.5, 0.8}, &walls);
    }
    core::RangeSensorInfo laser = TestLaser(25);
    laser.beams = beams;
    laser.angle_increment_rad = std::numbers::pi / (beams - 1);
    std::vector<geometry::Rigid2> poses;
    for (int i = 0; i < scans; ++i) {
      poses.push_back({{0.3 - 0.3 * i, 0.1}, 0.05 * i});
      const std::vector<float> ranges_m =
          CastScan(walls, poses.back(), laser, 0.01, static_cast<uint64_t>(i));
      window.push_back(MakeScanOutline(ranges_m, laser, {}));
    }
    for (size_t i = 0; i < window.size(); ++i) {
      references.push_back({.scan = &window[i], .target_from_scan = poses[i]});
    }
    scan = MakeScanOutline(CastScan(walls, truth, laser, 0.01, 99), laser, {});
  }
};

MatchSearch Search(double half_extent_m) {
  return {.half_extent_m = half_extent_m,
          .half_angle_rad = half_extent_m < 1 ? 0.2 : 0.6,
          .guess_sigma_m = 0.1,
          .guess_sigma_rad = 0.07};
}

// Arguments: beams, scans in the window.
void BM_DrawAndMatch(benchmark::State& state) {
  const Scene scene(static_cast<int>(state.range(0)),
                    static_cast<int>(state.range(1)));
  const ScanMatcherOptions options;
  const MatchSearch search = Search(0.3);
  const geometry::Rigid2 guess =
      scene.truth * geometry::Rigid2{{0.12, -0.1}, 0.08};
  for (auto _ : state) {
    const SurfaceGrid grid =
        MakeSurfaceGrid(scene.references, scene.scan, guess, search, options);
    benchmark::DoNotOptimize(
        MatchScan(grid, scene.scan, guess, search, options));
  }
}
BENCHMARK(BM_DrawAndMatch)
    ->Args({181, 15})
    ->Args({1081, 15})
    ->Unit(benchmark::kMillisecond);

// Arguments: beams, half the search's width (dm).
void BM_Match(benchmark::State& state) {
  const Scene scene(static_cast<int>(state.range(0)), 15);
  const ScanMatcherOptions options;
  const MatchSearch search = Search(0.1 * static_cast<double>(state.range(1)));
  const geometry::Rigid2 guess =
      scene.truth * geometry::Rigid2{{0.12, -0.1}, 0.08};
  const SurfaceGrid grid =
      MakeSurfaceGrid(scene.references, scene.scan, guess, search, options);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        MatchScan(grid, scene.scan, guess, search, options));
  }
}
BENCHMARK(BM_Match)->Args({181, 3})->Args({181, 40})->Args({1081, 3})->Unit(
    benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::mapping

BENCHMARK_MAIN();

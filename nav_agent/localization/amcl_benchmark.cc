// What an update costs, by particles and beams, on one core; compare
// design/navigation.md: 2,000 x 60 in 2.7 ms, 10,000 x 60 in 10.1 ms.
#include "benchmark/benchmark.h"
#include "nav_agent/localization/amcl.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline::localization {
namespace {

// range(0) particles, range(1) beams, in a map of 80 x 80 m.
void BM_Update(benchmark::State& state) {
  const core::OccupancyGrid small = TestingMap();
  core::OccupancyGrid map = core::OccupancyGrid::Filled(
      1600, 1600, 0.05, small.map_from_grid, core::Occupancy::kUnknown);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) map.Set({x, y}, small.At({x, y}));
  }
  const int particles = static_cast<int>(state.range(0));
  AmclOptions options;
  options.min_particles = particles;
  options.max_particles = particles;
  options.max_global_localization_particles = particles;
  options.max_beams = static_cast<int>(state.range(1));
  options.update_distance_m = 0;
  options.update_turn_rad = 0;
  Amcl amcl = *Amcl::Create(map, options, 1);
  const geometry::Rigid2 truth = {map.CenterInMap({80, 60}), 0.4};
  const bool is_set =
      amcl.SetPose(truth, {0.04, 0, 0, 0, 0.04, 0, 0, 0, 0.02}).ok();
  base::Random random(1, 1);
  const core::RangeSensorInfo info = {.angle_min_rad = -2.35,
                                      .angle_increment_rad = 4.7 / 1080,
                                      .beams = 1081,
                                      .range_min_m = 0.05,
                                      .range_max_m = 30,
                                      .beam_interval_s = 0,
                                      .scan_interval_s = 0.025};
  const ScanPoints points = *PointsOf(ScanOf(small, info, truth, 0.01, random),
                                      info, {}, options.max_beams);
  double x = 0;
  for (auto _ : state) {
    // To and fro, so that the particles stay.
    x = x == 0 ? 0.01 : 0;
    benchmark::DoNotOptimize(amcl.Update({{x, 0}, 0}, points));
  }
  state.counters["particles"] = static_cast<double>(amcl.particles().size());
  if (!is_set) state.SkipWithError("the pose was refused");
}
BENCHMARK(BM_Update)
    ->Args({500, 60})
    ->Args({2000, 60})
    ->Args({10000, 60})
    ->Args({30000, 60})
    ->Args({2000, 1081})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::localization

BENCHMARK_MAIN();

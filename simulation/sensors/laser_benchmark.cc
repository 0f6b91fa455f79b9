// Scans of a laser in the room.
#include "benchmark/benchmark.h"
#include "simulation/sensors/laser_scanner.h"

namespace treeline::sensors {
namespace {

void BM_Scan(benchmark::State& state, const char* name) {
  const worlds::World world = *worlds::MakeWorld(name, {});
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  const LaserScanner scanner = *LaserScanner::Create(world, {}, 1);
  const renderer::WorldSnapshot snapshot = caster.At(world.InstancesAt(1));
  geometry::Rigid3 from;
  from.translation = {world.size_m.x / 2.0, world.size_m.y / 2.0, 0.6};
  geometry::Rigid3 to = from;
  to.translation.x += 0.02;
  to.rotation = geometry::Rotation3::FromAxisAngle({0, 0, 0.02});
  uint64_t scan = 0;
  for (auto _ : state) {
    const LaserReturns returns = scanner.Scan(snapshot, from, to, scan++);
    benchmark::DoNotOptimize(returns.ranges_m.data());
  }
  state.counters["surfaces"] = static_cast<double>(world.surfaces.size());
  state.counters["scans/s"] = benchmark::Counter(static_cast<double>(scan),
                                                 benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(BM_Scan, room, "room")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace treeline::sensors

BENCHMARK_MAIN();

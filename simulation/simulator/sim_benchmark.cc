// How much faster than real time: items are simulated seconds, so that
// items_per_second is the factor.
#include <memory>
#include <utility>

#include "benchmark/benchmark.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/simulator.h"

namespace treeline::simulator {
namespace {

constexpr const char* kWorld = "cafe";

Scenario BenchmarkScenario(bool laser, double camera_hz) {
  Scenario scenario;
  scenario.world = kWorld;
  scenario.options.sensors.has_laser = laser;
  scenario.options.sensors.camera_hz = camera_hz;
  scenario.options.threads = 2;
  return scenario;
}

// One iteration: a simulated second of driving along the tour.
void DriveTour(benchmark::State& state, bool laser, double camera_hz) {
  Scenario scenario = BenchmarkScenario(laser, camera_hz);
  worlds::World world = *worlds::MakeWorld(kWorld, {.paint = camera_hz > 0});
  scenario.options.start = *StartOf(scenario, world);
  const auto simulator = *Simulator::Create(std::move(world), scenario.options);
  ScenarioPlayer player(scenario, *simulator);
  TourAction tour;
  tour.options.repeats = true;
  player.DriveTour(tour);
  for (auto _ : state) {
    for (int i = 0; i < 10; ++i) {
      player.Step(std::chrono::milliseconds(100));
      benchmark::DoNotOptimize(simulator->laser().TakeScans());
      benchmark::DoNotOptimize(simulator->odometry().TakeReadings());
      benchmark::DoNotOptimize(simulator->camera().TakeFrames());
    }
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["driven_m"] = simulator->state().distance_m;
}

void BM_Odometry(benchmark::State& state) { DriveTour(state, false, 0); }
BENCHMARK(BM_Odometry)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_LaserAndOdometry(benchmark::State& state) { DriveTour(state, true, 0); }
BENCHMARK(BM_LaserAndOdometry)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_LaserOdometryAndRgbdAt10Hz(benchmark::State& state) {
  DriveTour(state, true, 10);
}
BENCHMARK(BM_LaserOdometryAndRgbdAt10Hz)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_GroundQuery(benchmark::State& state) {
  const worlds::World world = *worlds::MakeWorld(kWorld, {.paint = false});
  const Terrain terrain(world);
  double x_m = 0;
  for (auto _ : state) {
    x_m = x_m < 12 ? x_m + 0.013 : 1;
    benchmark::DoNotOptimize(terrain.GroundAt({x_m, 5}, -0.02, 0.02));
  }
}
BENCHMARK(BM_GroundQuery);

void BM_CollisionCheck(benchmark::State& state) {
  Scenario scenario = BenchmarkScenario(false, 0);
  const worlds::World world = *worlds::MakeWorld(kWorld, {.paint = false});
  const RobotPlacement start = *StartOf(scenario, world);
  const Terrain terrain(world);
  const Stage stage(world);
  const Footing footing(terrain, core::RobotModel());
  Collider collider(terrain, stage, core::RobotModel());
  const Stance stance =
      *footing.PutDown(start.position, start.yaw_rad, start.height_m);
  for (auto _ : state) {
    benchmark::DoNotOptimize(collider.FindFixed(stance));
  }
}
BENCHMARK(BM_CollisionCheck);

}  // namespace
}  // namespace treeline::simulator

BENCHMARK_MAIN();

// How soon there is a path in the 13 x 10 m world, and how short it is after
// 100 ms: processor time, but of OMPL's planners by the clock.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "benchmark/benchmark.h"
#include "common/base/processor_time.h"
#include "nav_agent/planning/global_planner.h"
#include "simulation/worlds/world.h"
#include "tests/traversable_worlds/planner_maps.h"
#include "tests/traversable_worlds/testing_world.h"

namespace treeline {
namespace {

// Not among the seeds that suites are judged by.
constexpr uint64_t kSeed = 1000;

std::shared_ptr<const traversability::NavigationMap> MapOf(
    const std::string& name) {
  const auto world = worlds::MakeWorld(
      name, {.with_people = false, .threads = 1, .paint = false});
  if (!world.ok()) std::abort();
  auto levels = traversability::ExtractTraversableMap(VoxelizeWorld(*world));
  if (!levels.ok()) std::abort();
  auto map = traversability::NavigationMap::Make(*std::move(levels));
  if (!map.ok()) std::abort();
  return std::make_shared<const traversability::NavigationMap>(*std::move(map));
}

std::unique_ptr<planning::GlobalPlanner> PlannerOf(
    const std::shared_ptr<const traversability::NavigationMap>& map,
    const std::string& planner) {
  planning::GlobalPlannerOptions options;
  options.planner = planner;
  auto made = planning::MakeGlobalPlanner(map, core::RobotModel(), options);
  if (!made.ok()) std::abort();
  return *std::move(made);
}

void BM_FirstPath(benchmark::State& state, const std::string& world,
                  const std::string& planner_name) {
  const auto map = MapOf(world);
  const auto planner = PlannerOf(map, planner_name);
  const std::vector<planning::PlanRequest> requests =
      RequestsOn(map, 1000, kSeed);
  std::vector<double> first_ms;
  std::vector<double> none_ms;
  int failures = 0;
  size_t next = 0;
  for ([[maybe_unused]] const auto _ : state) {
    const bool is_own = planner_name == "variable-rrt";
    const double before_ms = base::ThreadProcessorTime_ms();
    const auto result = planner->Plan(
        requests[next++ % requests.size()],
        {.max_iterations = is_own ? 2000 : 20000, .improves = !is_own}, {});
    const double took_ms = base::ThreadProcessorTime_ms() - before_ms;
    if (!result.ok() || result->failure != core::NavigationCause::kNone) {
      ++failures;
      none_ms.push_back(took_ms);
      if (result.ok()) {
        std::printf("pair %zu: %s: %s\n", (next - 1) % requests.size(),
                    core::NavigationCauseName(result->failure),
                    result->why.c_str());
      }
      continue;
    }
    first_ms.push_back(is_own ? took_ms : 1e3 * result->first_path_s);
  }
  state.counters["p50_ms"] = Share(first_ms, 0.5);
  state.counters["p99_ms"] = Share(first_ms, 0.99);
  state.counters["max_ms"] = Share(first_ms, 1);
  state.counters["none_max_ms"] = Share(none_ms, 1);
  state.counters["failures"] = failures;
}

// The shortest path that several planners found in seconds.
double BestLength_m(
    const std::shared_ptr<const traversability::NavigationMap>& map,
    planning::PlanRequest request) {
  double best_m = std::numeric_limits<double>::infinity();
  for (const char* name : {"variable-rrt", "variable-rrt", "variable-rrt",
                           "bit-star", "informed-rrt-star"}) {
    request.seed += 7919;
    const auto result = PlannerOf(map, name)->Plan(
        request, {.max_iterations = 1'000'000'000, .max_time_s = 1}, {});
    if (result.ok() && result->failure == core::NavigationCause::kNone) {
      best_m = std::min(best_m, result->length_m);
    }
  }
  return best_m;
}

void BM_LengthAfter100ms(benchmark::State& state, const std::string& world) {
  const auto map = MapOf(world);
  const auto planner = PlannerOf(map, "variable-rrt");
  const std::vector<planning::PlanRequest> requests =
      RequestsOn(map, 30, kSeed);
  std::vector<double> best_m;
  best_m.reserve(requests.size());
  for (const planning::PlanRequest& request : requests) {
    best_m.push_back(BestLength_m(map, request));
  }
  const base::ThreadProcessorClock clock;
  std::vector<double> excess;
  int failures = 0;
  for ([[maybe_unused]] const auto _ : state) {
    for (size_t i = 0; i < requests.size(); ++i) {
      const auto result = planner->Plan(requests[i],
                                        {.max_iterations = 1'000'000'000,
                                         .max_time_s = 0.1,
                                         .improves = true,
                                         .clock = &clock},
                                        {});
      if (!result.ok() || result->failure != core::NavigationCause::kNone) {
        ++failures;
        continue;
      }
      excess.push_back(100 * (result->length_m / best_m[i] - 1));
    }
  }
  state.counters["p50_percent"] = Share(excess, 0.5);
  state.counters["p90_percent"] = Share(excess, 0.9);
  state.counters["max_percent"] = Share(excess, 1);
  state.counters["failures"] = failures;
}

void BM_MakePlanner(benchmark::State& state) {
  const auto map = MapOf("cafe");
  for ([[maybe_unused]] const auto _ : state) {
    benchmark::DoNotOptimize(PlannerOf(map, "variable-rrt"));
  }
}

BENCHMARK_CAPTURE(BM_FirstPath, cafe, "cafe", "variable-rrt")
    ->Iterations(1000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FirstPath, cafe_rrt_connect, "cafe", "rrt-connect")
    ->Iterations(300)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FirstPath, cafe_ompl_variable, "cafe", "ompl-variable-rrt")
    ->Iterations(300)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FirstPath, two_storey, "two-storey", "variable-rrt")
    ->Iterations(300)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FirstPath, office_floor, "office-floor", "variable-rrt")
    ->Iterations(300)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_LengthAfter100ms, cafe, "cafe")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_MakePlanner)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline

BENCHMARK_MAIN();

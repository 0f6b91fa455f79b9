// What the supervisor costs: Step at 40 Hz with full scans, over a simulated
// drive.
#include <time.h>

#include <algorithm>
#include <vector>

#include "benchmark/benchmark.h"
#include "common/base/processor_time.h"
#include "tests/robot/testing_mission.h"

namespace treeline {
namespace {

constexpr simulator::SimTime kPeriod = std::chrono::milliseconds(25);

// Only Step is measured: the simulation runs between. Counters: the share of a
// core that 40 steps a second take, and the longest step but one in a hundred.
// Plans are made within Step here; the longest steps are theirs.
void BM_Step(benchmark::State& state) {
  std::vector<double> steps_s;
  for (auto _ : state) {
    TestMission mission({});
    mission.Send({mission.At(9.2, 7.9)});
    double sum_s = 0;
    int steps = 0;
    while (steps < 400) {
      mission.simulator().Step(kPeriod);
      const double begin_s = 1e-3 * base::ThreadProcessorTime_ms();
      mission.navigator().Step();
      const double step_s = 1e-3 * base::ThreadProcessorTime_ms() - begin_s;
      ++steps;
      steps_s.push_back(step_s);
      sum_s += step_s;
    }
    state.SetIterationTime(sum_s / steps);
    benchmark::DoNotOptimize(mission.navigator().mode());
  }
  double sum_s = 0;
  for (const double step_s : steps_s) sum_s += step_s;
  std::ranges::sort(steps_s);
  state.counters["core_share"] =
      sum_s / static_cast<double>(steps_s.size()) / simulator::Seconds(kPeriod);
  state.counters["p50_ms"] = 1e3 * steps_s[steps_s.size() / 2];
  state.counters["p99_ms"] = 1e3 * steps_s[steps_s.size() * 99 / 100];
}
BENCHMARK(BM_Step)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(2);

void BM_Snapshot(benchmark::State& state) {
  TestMission mission({});
  mission.Send({mission.At(9.2, 7.9)});
  mission.Run(3);
  for (auto _ : state) {
    benchmark::DoNotOptimize(mission.navigator().Snapshot());
  }
}
BENCHMARK(BM_Snapshot)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace treeline

BENCHMARK_MAIN();

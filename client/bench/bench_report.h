// What a load test found, for people and for programs.
#ifndef CLIENT_BENCH_BENCH_REPORT_H_
#define CLIENT_BENCH_BENCH_REPORT_H_

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/bench/fail_condition.h"
#include "client/bench/load_generator.h"
#include "client/bench/machine.h"
#include "client/bench/server_course.h"
#include "client/bench/tally.h"

namespace treeline::bench {

struct WorkloadSummary {
  std::string scene;
  std::string encoding;
  int queries = 0;
  int with_truth = 0;
  double mean_bytes = 0;
};
std::vector<WorkloadSummary> Summarize(const std::vector<WorkItem>& items);

struct BenchReport {
  std::string server;
  std::string target = "grpc";  // as Target has them
  // That generated the load.
  int processes = 1;
  MachineFacts machine;
  std::array<double, 3> load_before{};
  std::array<double, 3> load_after{};
  std::vector<WorkloadSummary> workload;
  // Answers before the load; -1: was left out.
  int reference_answers = -1;
  // Answered in time and rightly by a closed loop; 0: was not measured.
  double capacity_per_s = 0;
  std::vector<LoadRun> runs;
  std::map<OutcomeKey, int64_t> all_calls;
  // What no run must show.
  std::vector<FailCondition> conditions;
  // The server's own metrics, if they were looked at.
  std::string metrics_url;
  std::optional<Course> course;
};

// docs/reference/load-and-faults.md has the keys.
std::string BenchJson(const BenchReport& report);
std::string BenchText(const BenchReport& report);

// Answers that were in time and not found wrong, per second of what was
// measured.
double Goodput_per_s(const LoadRun& run);

// "12.0 s  84.3/s  p50 11.2 ms  p99 30.1 ms  0 shed, 0 late, 0 failed".
std::string LiveLine(const Glance& glance, double at_s);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_BENCH_REPORT_H_

// What `treeline-client bench` is told.
#ifndef CLIENT_CLI_BENCH_FLAGS_H_
#define CLIENT_CLI_BENCH_FLAGS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/bench/fail_condition.h"
#include "client/bench/http_target.h"
#include "client/bench/load_generator.h"
#include "client/bench/worker_processes.h"
#include "client/bench/workload.h"
#include "client/cli/connection_flags.h"

namespace CLI {
class App;
}

namespace treeline::client_cli {

struct BenchFlags {
  ConnectionFlags connection;
  std::string target_name = "grpc";
  std::vector<std::string> scenes;
  std::vector<std::string> encodings = {"file"};
  bench::WorkloadOptions workload;
  bench::LoadOptions load;
  std::string ramp_rate;
  std::string ramp_concurrency;
  int attempts = 1;
  int connections = 0;  // 0: by target
  int processes = 1;
  int worker = -1;  // the number of this process among them; -1: none of them
  bool sweep = false;
  bool no_reference = false;
  double tolerance_m = 0.05;
  double tolerance_deg = 5;
  std::string fail_if;
  std::string metrics_url;
  std::string report_path;
  bool json = false;

  // What ParseBenchFlags makes of them.
  bench::Target target = bench::Target::kGrpc;
  std::vector<bench::LoadStep> steps;  // empty for a sweep
  std::vector<bench::FailCondition> conditions;
};

void AddBenchFlags(CLI::App& app, BenchFlags& flags);

// Reads what the flags say in text, and says what does not go together.
// INVALID_ARGUMENT.
absl::Status ParseBenchFlags(BenchFlags& flags);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_BENCH_FLAGS_H_

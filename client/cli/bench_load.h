// Where the load of `treeline-client bench` comes from: this process, or
// several.
#ifndef CLIENT_CLI_BENCH_LOAD_H_
#define CLIENT_CLI_BENCH_LOAD_H_

#include <map>
#include <memory>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/bench/load_generator.h"
#include "client/bench/worker_processes.h"
#include "client/cli/bench_flags.h"

namespace treeline::client_cli {

// Not thread-safe.
class BenchLoad {
 public:
  virtual ~BenchLoad() = default;

  // Asks for every answer once before the load, unless the flags forbid it.
  virtual absl::Status Prepare(const std::stop_token& stop) = 0;
  virtual absl::StatusOr<bench::LoadRun> Run(
      const bench::LoadStep& step, const std::stop_token& stop,
      const bench::LoadGenerator::Watch& watch) = 0;
  virtual std::map<bench::OutcomeKey, int64_t> AllCalls() const = 0;
};

// Of this process. `flags` and `items` must outlive it. Errors are those of
// the connection and of what the target cannot say.
absl::StatusOr<std::unique_ptr<BenchLoad>> MakeOwnLoad(
    const BenchFlags& flags, const std::vector<bench::WorkItem>& items);

// Of flags.processes copies of this program with its own arguments.
std::unique_ptr<BenchLoad> MakeLoadOfProcesses(const BenchFlags& flags);

// What such a copy does; the exit code.
int RunBenchWorker(const BenchFlags& flags, const std::stop_token& stop);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_BENCH_LOAD_H_

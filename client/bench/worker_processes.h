// One load from several processes.
#ifndef CLIENT_BENCH_WORKER_PROCESSES_H_
#define CLIENT_BENCH_WORKER_PROCESSES_H_

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/bench/run_record.h"

namespace treeline::bench {

// What of a load differs between its steps and its processes.
struct LoadStep {
  double rate_per_s = 0;  // as LoadOptions
  int concurrency = 1;
  uint64_t seed = 0;
};

// Process i's part of a step for `count` of them. A closed loop needs a client
// for each.
LoadStep PartOf(const LoadStep& step, int i, int count);

// Workers speak lines: after its preparation a worker says "ready"; for every
// line with a step that it reads it answers with a record, or with
// "error CODE MESSAGE" and its end. It ends when there are no more lines.

// The worker's side, on its standard input and output. False: it ended with an
// error, which it has said.
bool ServeSteps(
    std::istream& in, std::ostream& out,
    const std::function<absl::Status()>& prepare,
    const std::function<absl::StatusOr<RunRecord>(const LoadStep& step)>& run);

// The other side. Not thread-safe.
class WorkerProcesses {
 public:
  // Starts `count` processes of `command`, each with its number as a last
  // argument, and waits until all are ready. Their standard error is this
  // program's. CANCELLED: stopped. The destructor ends what still runs.
  static absl::StatusOr<std::unique_ptr<WorkerProcesses>> Start(
      const std::vector<std::string>& command, int count,
      const std::stop_token& stop);
  ~WorkerProcesses();
  WorkerProcesses(const WorkerProcesses&) = delete;
  WorkerProcesses& operator=(const WorkerProcesses&) = delete;

  // All at once; merged. Stopped, the workers are interrupted, and what they
  // have is the result.
  absl::StatusOr<LoadRun> Run(const LoadStep& step,
                              const std::stop_token& stop);

  // Of all workers, as of their last run.
  const std::map<OutcomeKey, int64_t>& all_calls() const { return all_calls_; }

 private:
  struct Worker;
  WorkerProcesses() = default;
  absl::Status Spawn(std::vector<std::string> command);
  absl::StatusOr<std::string> ReadLine(Worker& worker,
                                       const std::stop_token& stop);
  void Interrupt();

  std::vector<std::unique_ptr<Worker>> workers_;
  bool interrupted_ = false;
  std::map<OutcomeKey, int64_t> all_calls_;
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_WORKER_PROCESSES_H_

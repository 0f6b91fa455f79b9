// Asks a server, as many clients would.
#ifndef CLIENT_BENCH_LOAD_GENERATOR_H_
#define CLIENT_BENCH_LOAD_GENERATOR_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "client/bench/answer_checker.h"
#include "client/bench/latency_histogram.h"
#include "client/bench/tally.h"
#include "client/bench/transport.h"
#include "client/bench/workload.h"
#include "client/relocalizer/channel.h"

namespace treeline::bench {

struct LoadOptions {
  // Closed loop: so many clients, each of which asks again as soon as it has
  // its answer, or 10 ms after it had none.
  int concurrency = 1;
  // If it is positive, each of them asks with one stream, and keeps so many
  // frames of it in flight.
  int stream_window = 0;
  // Open loop instead, if it is positive: clients that know nothing of one
  // another ask so often in all, answered or not.
  double rate_per_s = 0;
  // What is measured, and what goes before it.
  double duration_s = 10;
  double warm_up_s = 1;
  // Of each call, from when it was to be sent, retries included.
  double deadline_ms = 10000;
  // Share of the calls that are cancelled here, each after a time that is
  // uniform between 0 and cancel_after_ms.
  double cancel_share = 0;
  double cancel_after_ms = 50;
  // Of arrivals and cancellations.
  uint64_t seed = 0;
  // Length of the parts that the result is told in, too; at least 0.01.
  double interval_s = 1;
  // Calls at a time in an open loop; more are not sent, and counted.
  int max_outstanding = 5000;

  absl::Status Validate() const;
};

// A generator that cannot keep its own schedule measures itself.
inline constexpr double kSaturatedLag_ms = 10;

struct LoadRun {
  LoadOptions options;
  std::chrono::system_clock::time_point measured_from;
  double measured_s = 0;
  // The whole run, warm-up and last answers included.
  double wall_s = 0;
  bool interrupted = false;
  // Calls that the interruption ended; they are counted nowhere else.
  int64_t abandoned = 0;
  TallyState tally;
  // Open loop: arrivals that were not sent, and how late the others were.
  int64_t not_sent = 0;
  LatencyHistogram send_lag;
  // Processor time that this process took, in processors.
  double generator_cpus = 0;

  // Whether the generator was the bottleneck: the 99th percentile of its delay
  // is over kSaturatedLag_ms, or something was not sent.
  bool saturated() const;
};

class LoadGenerator {
 public:
  // Calls and streams go over gRPC, over the connections in turn. `items` and
  // `checker` must outlive the generator.
  LoadGenerator(const std::vector<relocalizer::Connection>& connections,
                const std::vector<WorkItem>& items, AnswerChecker& checker);
  // Calls go over `transport`; there are no streams.
  LoadGenerator(std::unique_ptr<Transport> transport,
                const std::vector<WorkItem>& items, AnswerChecker& checker);
  // Waits for the calls that are still out.
  ~LoadGenerator();

  // Asks every query once, `concurrency` at a time. The first error ends it.
  absl::Status AskOnce(int concurrency, double deadline_ms,
                       const std::stop_token& stop);

  // Blocks until every call has ended. `watch` is called twice a second, on
  // another thread, with the seconds since the measurement began. Not to be
  // called twice at a time.
  using Watch = std::function<void(const Glance& glance, double at_s)>;
  LoadRun Run(const LoadOptions& options, const std::stop_token& stop,
              const Watch& watch);

  // Every call of every Run and AskOnce so far.
  std::map<OutcomeKey, int64_t> AllCalls() const;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_LOAD_GENERATOR_H_

// A run as bytes, between the processes of one load test, and several as one.
#ifndef CLIENT_BENCH_RUN_RECORD_H_
#define CLIENT_BENCH_RUN_RECORD_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/bench/load_generator.h"

namespace treeline::bench {

// What one process found in one run.
struct RunRecord {
  LoadRun run;
  // Of the process so far, as LoadGenerator::AllCalls.
  std::map<OutcomeKey, int64_t> all_calls;
};

// One line of JSON, without the newline. Histograms come whole, so that what is
// merged has the percentiles of all calls. Of the options only what merging
// needs is kept: rate, concurrency, window, deadline, warm-up, interval.
std::string WriteRunRecord(const RunRecord& record);
// INVALID_ARGUMENT: no such line.
absl::StatusOr<RunRecord> ParseRunRecord(absl::string_view line);

// The runs of processes that were at it at the same time, at least one, as one:
// counts, rates and processors add up.
LoadRun MergeRuns(const std::vector<LoadRun>& runs);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_RUN_RECORD_H_

// Many runs on some threads, of which an interrupt keeps what is done.
#ifndef EVALUATION_SUITES_SUITE_JOBS_H_
#define EVALUATION_SUITES_SUITE_JOBS_H_

#include <atomic>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/progress.h"

namespace treeline::suites {

// "7", "1-20" or "1-20,31". INVALID_ARGUMENT, with what it must be like, for
// other texts and for more than 10000.
absl::StatusOr<std::vector<uint64_t>> ParseSeedList(absl::string_view text);

// What was asked for: 0 is one a processor.
int ThreadsFor(int asked, size_t jobs);

template <typename Result>
struct JobResults {
  // Of those that were done, in the order of the jobs.
  std::vector<Result> done;
  // Of the first job that could not be run at all; it does not stop the others.
  absl::Status first_error = absl::OkStatus();
  int errors = 0;
};

// run(i), for i below `jobs`, returns a StatusOr<Result>; results do not depend
// on the number of threads if run's do not. Runs that `stop` ends are missing.
template <typename Result, typename Run>
JobResults<Result> RunJobs(size_t jobs, int threads, const std::string& label,
                           bool quiet, const std::stop_token& stop, Run run) {
  std::vector<std::optional<absl::StatusOr<Result>>> slots(jobs);
  base::Progress progress(label, static_cast<int64_t>(jobs > 0 ? jobs : 1),
                          quiet);
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < jobs && !stop.stop_requested(); i = next++) {
      slots[i] = run(i);
      progress.Add(1);
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int i = 1; i < ThreadsFor(threads, jobs); ++i) {
      workers.emplace_back(work);
    }
    work();
  }
  JobResults<Result> results;
  for (auto& slot : slots) {
    if (!slot.has_value()) continue;
    if (slot->ok()) {
      results.done.push_back(**std::move(slot));
    } else if (!absl::IsCancelled(slot->status())) {
      if (results.errors++ == 0) results.first_error = slot->status();
    }
  }
  return results;
}

// How a suite ends: CANCELLED if it was interrupted; the first run's error if
// one could not be run; FAILED_PRECONDITION if less than `required` of the runs
// were good.
absl::Status SuiteStatus(size_t done, size_t expected, double good_share,
                         double required, int errors,
                         const absl::Status& first_error,
                         const std::stop_token& stop);

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_JOBS_H_

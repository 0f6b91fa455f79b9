// What a load test must not show: "p99>50ms,wrong>0".
#ifndef CLIENT_BENCH_FAIL_CONDITION_H_
#define CLIENT_BENCH_FAIL_CONDITION_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/bench/load_generator.h"

namespace treeline::bench {

// One comparison of a figure of a run with a limit.
struct FailCondition {
  std::string text;    // as it was written, for messages
  std::string figure;  // a name of FigureNames
  bool above = true;   // fails above the limit; else below it
  bool or_equal = false;
  double limit = 0;  // in the figure's own unit
};

// Conditions separated by commas: FIGURE OP LIMIT [UNIT], OP of > >= < <=. For
// durations the unit is us, ms or s; for shares it is %; for rates it is /s or
// nothing; for counts there is none. INVALID_ARGUMENT says what is wrong where,
// and what there is.
absl::StatusOr<std::vector<FailCondition>> ParseFailConditions(
    absl::string_view text);

// For people: every figure, and what it is.
std::string FigureHelp();

// What of `conditions` is so in the run: "p99 is 61.2 ms (p99>50ms)". A figure
// that has no value, such as p99 without an answer, fails every condition on
// it: nothing is known to be good.
std::vector<std::string> Failures(const std::vector<FailCondition>& conditions,
                                  const LoadRun& run);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_FAIL_CONDITION_H_

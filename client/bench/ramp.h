// Loads that grow step by step.
#ifndef CLIENT_BENCH_RAMP_H_
#define CLIENT_BENCH_RAMP_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::bench {

// "FROM:TO:+STEP" or "FROM:TO:xFACTOR": 10:50:+20 is 10, 30, 50, and 1:10:x2 is
// 1, 2, 4, 8, 10: TO is the last, whether a step hits it or not. Or a list:
// "5,20,80". INVALID_ARGUMENT says what is wrong: nothing positive, steps that
// do not grow, more than 200 of them.
absl::StatusOr<std::vector<double>> ParseRamp(absl::string_view text);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_RAMP_H_

#include "evaluation/suites/suite_jobs.h"

#include <algorithm>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"

namespace treeline::suites {
namespace {

constexpr size_t kMaxSeeds = 10000;

}  // namespace

absl::StatusOr<std::vector<uint64_t>> ParseSeedList(absl::string_view text) {
  const absl::Status wrong = absl::InvalidArgumentError(absl::StrCat(
      "--seeds is '", text, "'; it must be like 7, 1-20 or 1-20,31"));
  std::vector<uint64_t> seeds;
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    const std::vector<absl::string_view> ends = absl::StrSplit(part, '-');
    uint64_t first = 0;
    uint64_t last = 0;
    if (ends.empty() || ends.size() > 2 ||
        !absl::SimpleAtoi(ends.front(), &first) ||
        !absl::SimpleAtoi(ends.back(), &last) || last < first ||
        last - first >= kMaxSeeds - seeds.size()) {
      return wrong;
    }
    for (uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
  }
  return seeds;
}

int ThreadsFor(int asked, size_t jobs) {
  const int processors =
      std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int threads = asked > 0 ? asked : processors;
  return std::max(1, std::min(threads, static_cast<int>(jobs)));
}

absl::Status SuiteStatus(size_t done, size_t expected, double good_share,
                         double required, int errors,
                         const absl::Status& first_error,
                         const std::stop_token& stop) {
  if (errors > 0) {
    return base::Annotate(
        first_error,
        absl::StrCat(errors, " of ", expected, " could not be run; the first"));
  }
  if (stop.stop_requested() || done < expected) {
    return absl::CancelledError(absl::StrCat(
        "interrupted: ", done, " of ", expected, " were run, and are kept"));
  }
  if (good_share < required) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "%.2f %% were good, and --require wants %.2f %%; those that failed "
        "are listed above",
        100 * good_share, 100 * required));
  }
  return absl::OkStatus();
}

}  // namespace treeline::suites

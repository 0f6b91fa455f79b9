// Reads metrics as strictly as Prometheus does, and more so: for tests.
#ifndef COMMON_METRICS_TESTING_EXPOSITION_H_
#define COMMON_METRICS_TESTING_EXPOSITION_H_

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::metrics {

struct ParsedFamily {
  std::string type;
  std::string help;
  // By the sample as it stands there, labels sorted and unescaped:
  // "treeline_requests_total{rpc=Localize,status=OK}".
  std::map<std::string, double> samples;
};

// Families by name. INVALID_ARGUMENT names the line: not the text format 0.0.4,
// a family without HELP and TYPE in front or in two places, a sample twice, a
// counter below 0, a histogram whose buckets do not ascend, end in +Inf, or
// agree with its count.
absl::StatusOr<std::map<std::string, ParsedFamily>> ParseExposition(
    absl::string_view text);

// The value of a sample, by the same key; 0 if it is not there.
double SampleOf(const std::map<std::string, ParsedFamily>& families,
                const std::string& key);

}  // namespace treeline::metrics

#endif  // COMMON_METRICS_TESTING_EXPOSITION_H_

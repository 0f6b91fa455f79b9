// What /metrics answers, as values.
#ifndef CLIENT_SCRAPE_METRICS_TEXT_H_
#define CLIENT_SCRAPE_METRICS_TEXT_H_

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::scrape {

using Labels = std::map<std::string, std::string>;

// The samples of one moment. Immutable.
class MetricsSnapshot {
 public:
  // Prometheus' text format 0.0.4; comments are passed over, and so are time
  // stamps. INVALID_ARGUMENT names the line.
  static absl::StatusOr<MetricsSnapshot> Parse(absl::string_view text);

  // Whether there is any sample of this name.
  bool Has(const std::string& name) const { return samples_.count(name) > 0; }
  // The sum of the samples of this name that have all these labels; 0 without.
  double Sum(const std::string& name, const Labels& match = {}) const;
  // The same for each value of a label.
  std::map<std::string, double> SumBy(const std::string& name,
                                      const std::string& label) const;
  // The buckets of a histogram, cumulative, by their upper bound (+Inf too).
  std::map<double, double> Buckets(const std::string& histogram,
                                   const Labels& match = {}) const;

 private:
  using Sample = std::pair<Labels, double>;
  std::map<std::string, std::vector<Sample>> samples_;
};

// The value that a share of the observations is not above, as PromQL's
// histogram_quantile has it: linear within a bucket, and the last finite bound
// beyond it. NaN without observations. `buckets` as Buckets gives them.
double HistogramQuantile(double share, const std::map<double, double>& buckets);

}  // namespace treeline::scrape

#endif  // CLIENT_SCRAPE_METRICS_TEXT_H_

// Prometheus' text format 0.0.4:
// https://prometheus.io/docs/instrumenting/exposition_formats
#ifndef COMMON_METRICS_EXPOSITION_H_
#define COMMON_METRICS_EXPOSITION_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::metrics {

inline constexpr char kExpositionContentType[] =
    "text/plain; version=0.0.4; charset=utf-8";

enum class MetricType { kCounter, kGauge, kHistogram };

// {{"scene", "kitchen"}, {"outcome", "LOCALIZED"}}.
using Labels = std::vector<std::pair<std::string, std::string>>;

// counts[i]: observations at most upper_bounds[i] and above the bound before;
// the last, counts[upper_bounds.size()]: the rest. Not cumulative.
struct HistogramCounts {
  std::vector<double> upper_bounds;
  std::vector<uint64_t> counts;
  double sum = 0;
};

// Writes families one after the other.
class Exposition {
 public:
  // Starts a family; its samples must follow at once.
  void Family(absl::string_view name, absl::string_view help, MetricType type);
  // A sample of the family. Label values may be any bytes: what is not UTF-8
  // becomes U+FFFD, since Prometheus would refuse the whole page for it.
  void Sample(const Labels& labels, double value);
  void Histogram(const Labels& labels, const HistogramCounts& histogram);

  const std::string& text() const { return text_; }

 private:
  void Line(absl::string_view suffix, const Labels& labels,
            const std::pair<absl::string_view, std::string>* more,
            double value);

  std::string name_;
  std::string text_;
};

// The shortest text that reads back as the same double; "+Inf", "-Inf", "NaN".
std::string NumberText(double value);

// [a-zA-Z_:][a-zA-Z0-9_:]*
bool IsMetricName(absl::string_view name);
// [a-zA-Z_][a-zA-Z0-9_]*, but not __..., which is Prometheus' own.
bool IsLabelName(absl::string_view name);

}  // namespace treeline::metrics

#endif  // COMMON_METRICS_EXPOSITION_H_

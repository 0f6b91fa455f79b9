// Prometheus' text format 0.0.4, and OpenMetrics 1.0, which has exemplars:
// https://prometheus.io/docs/instrumenting/exposition_formats
// https://github.com/prometheus/OpenMetrics/blob/v1.0.0/specification/OpenMetrics.md
#ifndef COMMON_METRICS_EXPOSITION_H_
#define COMMON_METRICS_EXPOSITION_H_

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::metrics {

enum class ExpositionFormat { kPrometheus, kOpenMetrics };

// Of the answer to who asks for metrics.
const char* ContentTypeOf(ExpositionFormat format);
// What a scraper's header `Accept` prefers; OpenMetrics only where it is named.
ExpositionFormat FormatFor(absl::string_view accept);

enum class MetricType { kCounter, kGauge, kHistogram };

// {{"scene", "kitchen"}, {"outcome", "LOCALIZED"}}.
using Labels = std::vector<std::pair<std::string, std::string>>;

// One of the observations that a bucket has counted.
struct Exemplar {
  double value = 0;
  // Of the trace that it belongs to: 32 hexadecimal digits.
  std::string trace_id;
  // When it was made, seconds since 1970.
  double unix_s = 0;
};

// counts[i]: observations at most upper_bounds[i] and above the bound before;
// the last, counts[upper_bounds.size()]: the rest. Not cumulative.
struct HistogramCounts {
  std::vector<double> upper_bounds;
  std::vector<uint64_t> counts;
  double sum = 0;
  // Of each count; empty: none at all. Only OpenMetrics has room for them.
  std::vector<std::optional<Exemplar>> exemplars = {};
};

// Writes families one after the other.
class Exposition {
 public:
  explicit Exposition(ExpositionFormat format = ExpositionFormat::kPrometheus)
      : format_(format) {}

  // Starts a family; its samples must follow at once. The name of a counter
  // ends in _total.
  void Family(absl::string_view name, absl::string_view help, MetricType type);
  // A sample of the family. Label values may be any bytes: what is not UTF-8
  // becomes U+FFFD, since Prometheus would refuse the whole page for it.
  void Sample(const Labels& labels, double value);
  void Histogram(const Labels& labels, const HistogramCounts& histogram);

  // After the last family.
  void End();

  const std::string& text() const { return text_; }

 private:
  void Line(absl::string_view suffix, const Labels& labels,
            const std::pair<absl::string_view, std::string>* more, double value,
            const std::optional<Exemplar>& exemplar = std::nullopt);
  std::string BoundText(double bound) const;

  const ExpositionFormat format_;
  // Without what OpenMetrics adds to it by itself.
  std::string name_;
  absl::string_view sample_suffix_;
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

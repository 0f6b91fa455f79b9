#include "common/metrics/registry.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace treeline::metrics {
namespace {

// "Others", where there are too many to tell apart.
constexpr char kOther[] = "other";

template <typename Metric>
void WriteValues(const std::string& name, const std::string& help,
                 MetricType type, const MetricFamily<Metric>& family,
                 Exposition& out) {
  out.Family(name, help, type);
  family.ForEach([&](const Labels& labels, const Metric& metric) {
    out.Sample(labels, static_cast<double>(metric.value()));
  });
}

}  // namespace

Histogram::Histogram(std::vector<double> upper_bounds)
    : upper_bounds_(std::move(upper_bounds)),
      counts_(upper_bounds_.size() + 1) {
  if (!std::is_sorted(upper_bounds_.begin(), upper_bounds_.end())) std::abort();
}

size_t Histogram::Count(double value) {
  const auto bound =
      std::isnan(value)
          ? upper_bounds_.end()
          : std::lower_bound(upper_bounds_.begin(), upper_bounds_.end(), value);
  const auto at = static_cast<size_t>(bound - upper_bounds_.begin());
  counts_[at].fetch_add(1, std::memory_order_relaxed);
  if (std::isnan(value)) return at;
  double sum = sum_.load(std::memory_order_relaxed);
  while (!sum_.compare_exchange_weak(sum, sum + value,
                                     std::memory_order_relaxed)) {
  }
  return at;
}

void Histogram::Observe(double value) { Count(value); }

void Histogram::Observe(const Exemplar& exemplar) {
  const size_t at = Count(exemplar.value);
  const absl::MutexLock lock(&mutex_);
  exemplars_.resize(counts_.size());
  exemplars_[at] = exemplar;
}

HistogramCounts Histogram::Counts() const {
  HistogramCounts counts;
  counts.upper_bounds = upper_bounds_;
  for (const std::atomic<uint64_t>& count : counts_) {
    counts.counts.push_back(count.load(std::memory_order_relaxed));
  }
  counts.sum = sum_.load(std::memory_order_relaxed);
  const absl::MutexLock lock(&mutex_);
  counts.exemplars = exemplars_;
  return counts;
}

template <typename Metric>
Metric& MetricFamily<Metric>::With(
    const std::vector<std::string>& label_values) {
  if (label_values.size() != label_names_.size()) std::abort();
  absl::MutexLock lock(&mutex_);
  auto found = metrics_.find(label_values);
  if (found == metrics_.end()) {
    // The last place is for the others.
    const bool fits = metrics_.size() + 1 < kMaxSeries;
    found = metrics_
                .try_emplace(fits ? label_values
                                  : std::vector<std::string>(
                                        label_names_.size(), kOther))
                .first;
    if (found->second == nullptr) found->second = make_();
  }
  return *found->second;
}

template <typename Metric>
void MetricFamily<Metric>::ForEach(
    const std::function<void(const Labels&, const Metric&)>& visit) const {
  std::vector<std::pair<Labels, const Metric*>> metrics;
  {
    absl::MutexLock lock(&mutex_);
    metrics.reserve(metrics_.size());
    for (const auto& [values, metric] : metrics_) {
      Labels labels;
      for (size_t i = 0; i < values.size(); ++i) {
        labels.emplace_back(label_names_[i], values[i]);
      }
      // They are never removed.
      metrics.emplace_back(std::move(labels), metric.get());
    }
  }
  for (const auto& [labels, metric] : metrics) visit(labels, *metric);
}

template class MetricFamily<Counter>;
template class MetricFamily<Gauge>;
template class MetricFamily<Histogram>;

MetricFamily<Counter>& Registry::AddCounter(
    const std::string& name, const std::string& help,
    std::vector<std::string> label_names) {
  auto family = std::make_shared<MetricFamily<Counter>>(
      std::move(label_names), [] { return std::make_unique<Counter>(); });
  families_.push_back(family);
  sources_.emplace_back([name, help, family](Exposition& out) {
    WriteValues(name, help, MetricType::kCounter, *family, out);
  });
  return *family;
}

MetricFamily<Gauge>& Registry::AddGauge(const std::string& name,
                                        const std::string& help,
                                        std::vector<std::string> label_names) {
  auto family = std::make_shared<MetricFamily<Gauge>>(
      std::move(label_names), [] { return std::make_unique<Gauge>(); });
  families_.push_back(family);
  sources_.emplace_back([name, help, family](Exposition& out) {
    WriteValues(name, help, MetricType::kGauge, *family, out);
  });
  return *family;
}

MetricFamily<Histogram>& Registry::AddHistogram(
    const std::string& name, const std::string& help,
    std::vector<std::string> label_names, std::vector<double> upper_bounds) {
  auto family = std::make_shared<MetricFamily<Histogram>>(
      std::move(label_names), [bounds = std::move(upper_bounds)] {
        return std::make_unique<Histogram>(bounds);
      });
  families_.push_back(family);
  sources_.emplace_back([name, help, family](Exposition& out) {
    out.Family(name, help, MetricType::kHistogram);
    family->ForEach([&](const Labels& labels, const Histogram& histogram) {
      out.Histogram(labels, histogram.Counts());
    });
  });
  return *family;
}

void Registry::AddSource(std::function<void(Exposition&)> write) {
  sources_.push_back(std::move(write));
}

std::string Registry::Expose(ExpositionFormat format) const {
  Exposition out(format);
  for (const auto& write : sources_) write(out);
  out.End();
  return out.text();
}

std::vector<double> LatencyBuckets() {
  return {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
          0.1,    0.25,  0.5,    1,     2.5,  5,     10};
}

std::vector<double> ShareBuckets() {
  std::vector<double> bounds;
  for (int i = 1; i <= 20; ++i) bounds.push_back(i / 20.0);
  return bounds;
}

}  // namespace treeline::metrics

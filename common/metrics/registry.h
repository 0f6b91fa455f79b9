// Figures that a program keeps about itself.
#ifndef COMMON_METRICS_REGISTRY_H_
#define COMMON_METRICS_REGISTRY_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/metrics/exposition.h"

namespace treeline::metrics {

// Counts; never goes down. Thread-safe, without a lock.
class Counter {
 public:
  void Add(uint64_t n = 1) { value_.fetch_add(n, std::memory_order_relaxed); }
  uint64_t value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<uint64_t> value_ = 0;
};

// Goes up and down. Thread-safe, without a lock.
class Gauge {
 public:
  void Set(double value) { value_.store(value, std::memory_order_relaxed); }
  double value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<double> value_ = 0;
};

// Counts observations by size. Thread-safe, without a lock but for exemplars:
// what is read while others observe may lack the latest of them, and its sum
// may be ahead of its counts.
class Histogram {
 public:
  // `upper_bounds` ascend.
  explicit Histogram(std::vector<double> upper_bounds);
  // NaN counts as greater than all bounds, and not into the sum.
  void Observe(double value);
  // The same, and keeps it as its bucket's exemplar in place of the one before.
  void Observe(const Exemplar& exemplar);
  HistogramCounts Counts() const;

 private:
  // Counts it; where.
  size_t Count(double value);

  const std::vector<double> upper_bounds_;
  std::vector<std::atomic<uint64_t>> counts_;
  std::atomic<double> sum_ = 0;
  mutable absl::Mutex mutex_;
  // Of each count; empty until there is one.
  std::vector<std::optional<Exemplar>> exemplars_ ABSL_GUARDED_BY(mutex_);
};

// Metrics of one name, told apart by the values of their labels. At most
// kMaxSeries of them: what comes after that is counted together in one whose
// labels all say "other", so that nothing is lost and nothing grows without
// bound.
template <typename Metric>
class MetricFamily {
 public:
  static constexpr size_t kMaxSeries = 1000;

  MetricFamily(std::vector<std::string> label_names,
               std::function<std::unique_ptr<Metric>()> make)
      : label_names_(std::move(label_names)), make_(std::move(make)) {}

  // The metric with these values, in the order of the names; made when it is
  // first asked for. It stays where it is: hot paths may keep it.
  Metric& With(const std::vector<std::string>& label_values);

  // Calls `visit` for each, sorted by the values, without holding the lock.
  void ForEach(
      const std::function<void(const Labels&, const Metric&)>& visit) const;

 private:
  const std::vector<std::string> label_names_;
  const std::function<std::unique_ptr<Metric>()> make_;
  mutable absl::Mutex mutex_;
  std::map<std::vector<std::string>, std::unique_ptr<Metric>> metrics_
      ABSL_GUARDED_BY(mutex_);
};

extern template class MetricFamily<Counter>;
extern template class MetricFamily<Gauge>;
extern template class MetricFamily<Histogram>;

// All figures of one program. Families are added before Expose() is called for
// the first time, each name once; they live as long as the registry.
class Registry {
 public:
  Registry() = default;
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  MetricFamily<Counter>& AddCounter(const std::string& name,
                                    const std::string& help,
                                    std::vector<std::string> label_names);
  MetricFamily<Gauge>& AddGauge(const std::string& name,
                                const std::string& help,
                                std::vector<std::string> label_names);
  MetricFamily<Histogram>& AddHistogram(const std::string& name,
                                        const std::string& help,
                                        std::vector<std::string> label_names,
                                        std::vector<double> upper_bounds);
  // Figures that somebody else keeps: `write` adds whole families each time
  // they are asked for. Called from any thread, with no lock held.
  void AddSource(std::function<void(Exposition&)> write);

  // All of them, as text. Thread-safe.
  std::string Expose(
      ExpositionFormat format = ExpositionFormat::kPrometheus) const;

 private:
  std::vector<std::function<void(Exposition&)>> sources_;
  std::vector<std::shared_ptr<void>> families_;
};

// Upper bounds (s) for what takes from half a millisecond to ten seconds.
std::vector<double> LatencyBuckets();
// 0.05, 0.1, ... 1: for shares and probabilities.
std::vector<double> ShareBuckets();

}  // namespace treeline::metrics

#endif  // COMMON_METRICS_REGISTRY_H_

// Counts of durations, from microseconds to hours, in little memory.
#ifndef CLIENT_BENCH_LATENCY_HISTOGRAM_H_
#define CLIENT_BENCH_LATENCY_HISTOGRAM_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "absl/status/statusor.h"

namespace treeline::bench {

// Durations are counted in buckets whose width grows with the duration, as in
// HdrHistogram: below 128 us one bucket a microsecond, above it 64 buckets for
// every doubling, so that a percentile is at most 1/64 too high and never too
// low. Durations over 2^40 us count as that. Not thread-safe.
class LatencyHistogram {
 public:
  // Negative durations count as 0.
  void Add(double milliseconds);
  void Merge(const LatencyHistogram& other);

  int64_t count() const { return count_; }
  // 0 if nothing was counted.
  double mean_ms() const;
  double max_ms() const { return max_ms_; }
  // The nearest-rank percentile, percent in (0, 100]: at least this share of
  // all durations is not above it. 0 if nothing was counted.
  double Percentile_ms(double percent) const;

  // All that it knows, to be written and read by another process.
  struct Parts {
    std::map<size_t, int64_t> buckets = {};  // those that are used
    double sum_ms = 0;
    double max_ms = 0;
  };
  Parts ToParts() const;
  // INVALID_ARGUMENT: no histogram has such parts.
  static absl::StatusOr<LatencyHistogram> FromParts(const Parts& parts);

 private:
  std::vector<int64_t> buckets_;  // up to the last that is used
  int64_t count_ = 0;
  double sum_ms_ = 0;
  double max_ms_ = 0;
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_LATENCY_HISTOGRAM_H_

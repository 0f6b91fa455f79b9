#include "client/bench/latency_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace treeline::bench {
namespace {

constexpr int kLogBucketsPerDoubling = 6;
constexpr uint64_t kExactBelow_us = 2u << kLogBucketsPerDoubling;
constexpr double kLongest_us = 0x1p40;

// Buckets of width 2^shift: 64 of them make up one doubling.
size_t BucketOf(uint64_t us) {
  if (us < kExactBelow_us) return us;
  const int shift =
      static_cast<int>(std::bit_width(us)) - 1 - kLogBucketsPerDoubling;
  return (static_cast<size_t>(shift) << kLogBucketsPerDoubling) + (us >> shift);
}

// The longest duration of a bucket.
double LastOf_us(size_t bucket) {
  if (bucket < kExactBelow_us) return static_cast<double>(bucket);
  const size_t shift = (bucket >> kLogBucketsPerDoubling) - 1;
  const size_t in_doubling = bucket - (shift << kLogBucketsPerDoubling);
  return static_cast<double>(((in_doubling + 1) << shift) - 1);
}

}  // namespace

void LatencyHistogram::Add(double milliseconds) {
  // Rounded up, so that no percentile is too low; but 7 us are 7 us, although
  // 0.007 * 1000 is more.
  const double us =
      std::clamp(std::ceil(milliseconds * 1e3 - 1e-6), 0.0, kLongest_us);
  const size_t bucket = BucketOf(static_cast<uint64_t>(us));
  if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
  ++buckets_[bucket];
  ++count_;
  sum_ms_ += std::max(milliseconds, 0.0);
  max_ms_ = std::max(max_ms_, milliseconds);
}

void LatencyHistogram::Merge(const LatencyHistogram& other) {
  if (other.buckets_.size() > buckets_.size()) {
    buckets_.resize(other.buckets_.size());
  }
  for (size_t i = 0; i < other.buckets_.size(); ++i) {
    buckets_[i] += other.buckets_[i];
  }
  count_ += other.count_;
  sum_ms_ += other.sum_ms_;
  max_ms_ = std::max(max_ms_, other.max_ms_);
}

double LatencyHistogram::mean_ms() const {
  return count_ == 0 ? 0 : sum_ms_ / static_cast<double>(count_);
}

double LatencyHistogram::Percentile_ms(double percent) const {
  if (count_ == 0) return 0;
  const double rank =
      std::max(1.0, std::ceil(percent * static_cast<double>(count_) / 100));
  int64_t below = 0;
  for (size_t i = 0; i < buckets_.size(); ++i) {
    below += buckets_[i];
    if (static_cast<double>(below) >= rank) {
      return std::min(LastOf_us(i) * 1e-3, max_ms_);
    }
  }
  return max_ms_;
}

LatencyHistogram::Parts LatencyHistogram::ToParts() const {
  Parts parts{.sum_ms = sum_ms_, .max_ms = max_ms_};
  for (size_t i = 0; i < buckets_.size(); ++i) {
    if (buckets_[i] > 0) parts.buckets[i] = buckets_[i];
  }
  return parts;
}

absl::StatusOr<LatencyHistogram> LatencyHistogram::FromParts(
    const Parts& parts) {
  LatencyHistogram histogram;
  const size_t buckets = BucketOf(static_cast<uint64_t>(kLongest_us)) + 1;
  for (const auto& [bucket, count] : parts.buckets) {
    if (bucket >= buckets || count < 1) {
      return absl::InvalidArgumentError("no bucket of a histogram");
    }
    histogram.buckets_.resize(bucket + 1);
    histogram.buckets_[bucket] = count;
    histogram.count_ += count;
  }
  if (!std::isfinite(parts.sum_ms) || !std::isfinite(parts.max_ms)) {
    return absl::InvalidArgumentError("a histogram's times are not finite");
  }
  histogram.sum_ms_ = parts.sum_ms;
  histogram.max_ms_ = parts.max_ms;
  return histogram;
}

}  // namespace treeline::bench

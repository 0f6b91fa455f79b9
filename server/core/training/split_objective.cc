#include "server/core/training/split_objective.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace treeline::training {

double BalanceObjective(std::span<const int16_t> values, int threshold) {
  if (values.empty()) return 1;
  int64_t left = 0;
  for (int16_t value : values) left += value <= threshold;
  const int64_t total = static_cast<int64_t>(values.size());
  return static_cast<double>(std::llabs(2 * left - total)) /
         static_cast<double>(total);
}

VarianceSplitter::VarianceSplitter() : bins_(kBins) {}

ThresholdChoice VarianceSplitter::Best(std::span<const int16_t> values,
                                       std::span<const Label> labels,
                                       int min_side) {
  // With S the sum of n labels, sum |m - mean|^2 = sum |m|^2 - |S|^2 / n, and
  // the first term is the same for every split: maximise
  // |S_left|^2 / n_left + |S_right|^2 / n_right - |S|^2 / n.
  int low = kBins;
  int high = -1;
  Sum total;
  for (size_t i = 0; i < values.size(); ++i) {
    const int bin = values[i] + 255;
    low = std::min(low, bin);
    high = std::max(high, bin);
    Sum& sum = bins_[static_cast<size_t>(bin)];
    sum.x += labels[i].x;
    sum.y += labels[i].y;
    sum.z += labels[i].z;
    ++sum.count;
    total.x += labels[i].x;
    total.y += labels[i].y;
    total.z += labels[i].z;
    ++total.count;
  }
  const auto term = [](double x, double y, double z, double count) {
    return (x * x + y * y + z * z) / count;
  };
  ThresholdChoice best;
  double best_score = -1;
  double x = 0;
  double y = 0;
  double z = 0;
  int32_t left = 0;
  for (int bin = low; bin <= high; ++bin) {
    Sum& sum = bins_[static_cast<size_t>(bin)];
    if (sum.count == 0) continue;
    x += sum.x;
    y += sum.y;
    z += sum.z;
    left += sum.count;
    sum = Sum{};
    const int32_t right = total.count - left;
    if (left < min_side || right < min_side || right == 0) continue;
    const double score = term(x, y, z, left) +
                         term(total.x - x, total.y - y, total.z - z, right);
    if (score > best_score) {
      best_score = score;
      best.threshold = bin - 255;
    }
  }
  if (best_score >= 0) {
    best.gain = std::max(
        0.0, best_score - term(total.x, total.y, total.z, total.count));
  }
  return best;
}

// Moments of one side of a split, in double: differences of large sums.
struct EntropySplitter::Sum {
  double x = 0, y = 0, z = 0;
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  int32_t count = 0;

  void Add(const Moments& m) {
    x += static_cast<double>(m.x);
    y += static_cast<double>(m.y);
    z += static_cast<double>(m.z);
    xx += static_cast<double>(m.xx);
    xy += static_cast<double>(m.xy);
    xz += static_cast<double>(m.xz);
    yy += static_cast<double>(m.yy);
    yz += static_cast<double>(m.yz);
    zz += static_cast<double>(m.zz);
    count += m.count;
  }

  Sum Less(const Sum& o) const {
    return {x - o.x,   y - o.y,   z - o.z,   xx - o.xx, xy - o.xy,
            xz - o.xz, yy - o.yy, yz - o.yz, zz - o.zz, count - o.count};
  }

  // n log|covariance + noise|: 2 n E(S) but for what every split shares.
  double Entropy() const {
    const double n = count;
    const double noise = kLabelSigma_m * kLabelSigma_m;
    const double mx = x / n;
    const double my = y / n;
    const double mz = z / n;
    // Rounding may leave a variance of no spread below zero.
    const double cxx = std::max(0.0, xx / n - mx * mx) + noise;
    const double cyy = std::max(0.0, yy / n - my * my) + noise;
    const double czz = std::max(0.0, zz / n - mz * mz) + noise;
    const double cxy = xy / n - mx * my;
    const double cxz = xz / n - mx * mz;
    const double cyz = yz / n - my * mz;
    const double determinant = cxx * (cyy * czz - cyz * cyz) -
                               cxy * (cxy * czz - cyz * cxz) +
                               cxz * (cxy * cyz - cyy * cxz);
    return n * std::log(std::max(determinant, noise * noise * noise));
  }
};

EntropySplitter::EntropySplitter() : bins_(kBins) {}

EntropySplitter::Range EntropySplitter::Fill(std::span<const int16_t> values,
                                             std::span<const Label> labels) {
  Range range{kBins, -1};
  for (size_t i = 0; i < values.size(); ++i) {
    const int bin = values[i] + 255;
    range.low = std::min(range.low, bin);
    range.high = std::max(range.high, bin);
    Moments& m = bins_[static_cast<size_t>(bin)];
    const auto [x, y, z] = labels[i];
    m.x += x;
    m.y += y;
    m.z += z;
    m.xx += x * x;
    m.xy += x * y;
    m.xz += x * z;
    m.yy += y * y;
    m.yz += y * z;
    m.zz += z * z;
    ++m.count;
  }
  return range;
}

ThresholdChoice EntropySplitter::Best(std::span<const int16_t> values,
                                      std::span<const Label> labels,
                                      int min_side) {
  const auto [low, high] = Fill(values, labels);
  Sum total;
  int32_t occupied = 0;
  for (int bin = low; bin <= high; ++bin) {
    const Moments& m = bins_[static_cast<size_t>(bin)];
    if (m.count == 0) continue;
    ++occupied;
    total.Add(m);
  }
  ThresholdChoice best;
  // With more, a threshold is tried each time that many samples have passed.
  const int32_t stride =
      occupied - 1 <= kMaxThresholds ? 1 : total.count / (kMaxThresholds + 1);
  double least = std::numeric_limits<double>::infinity();
  int32_t next = 0;
  Sum left;
  for (int bin = low; bin <= high; ++bin) {
    Moments& m = bins_[static_cast<size_t>(bin)];
    if (m.count == 0) continue;
    left.Add(m);
    m = Moments{};
    const int32_t right = total.count - left.count;
    if (left.count < min_side || right < min_side || right == 0 ||
        left.count < next) {
      continue;
    }
    next = left.count + stride;
    const double after = left.Entropy() + total.Less(left).Entropy();
    if (after < least) {
      least = after;
      best.threshold = bin - 255;
    }
  }
  if (std::isfinite(least)) {
    best.gain = std::max(0.0, 0.5 * (total.Entropy() - least));
  }
  return best;
}

}  // namespace treeline::training

#include "server/core/training/split_objective.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace treeline {

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

}  // namespace treeline

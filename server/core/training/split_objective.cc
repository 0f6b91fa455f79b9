#include "server/core/training/split_objective.h"

#include <algorithm>
#include <array>
#include <bit>
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

// With S the sum of n labels, sum |m - mean|^2 = sum |m|^2 - |S|^2 / n, and the
// first term is the same for every split: maximise
// |S_left|^2 / n_left + |S_right|^2 / n_right - |S|^2 / n.
class VarianceSplitter::Sweep {
 public:
  Sweep(const Sum& total, int min_side)
      : x_(static_cast<double>(total.lanes[0])),
        y_(static_cast<double>(total.lanes[1])),
        z_(static_cast<double>(total.lanes[2])),
        count_(static_cast<double>(total.lanes[3])),
        min_side_(min_side) {}

  // All samples of the next value.
  void Add(const Sum& sum, int value) {
    left_x_ += static_cast<double>(sum.lanes[0]);
    left_y_ += static_cast<double>(sum.lanes[1]);
    left_z_ += static_cast<double>(sum.lanes[2]);
    left_ += static_cast<double>(sum.lanes[3]);
    const double right = count_ - left_;
    if (left_ < min_side_ || right < min_side_ || right == 0) return;
    const double score = Term(left_x_, left_y_, left_z_, left_) +
                         Term(x_ - left_x_, y_ - left_y_, z_ - left_z_, right);
    if (score > best_score_) {
      best_score_ = score;
      threshold_ = value;
    }
  }

  ThresholdChoice Best() const {
    if (best_score_ < 0) return {};
    return {threshold_, std::max(0.0, best_score_ - Term(x_, y_, z_, count_))};
  }

 private:
  static double Term(double x, double y, double z, double count) {
    return (x * x + y * y + z * z) / count;
  }

  const double x_;
  const double y_;
  const double z_;
  const double count_;
  const double min_side_;
  double left_x_ = 0;
  double left_y_ = 0;
  double left_z_ = 0;
  double left_ = 0;
  double best_score_ = -1;
  int threshold_ = 0;
};

VarianceSplitter::VarianceSplitter() : bins_(kBins) {}

void VarianceSplitter::SetLabels(std::span<const Label> labels) {
  labels_.resize(labels.size());
  total_ = Sum{};
  for (size_t i = 0; i < labels.size(); ++i) {
    labels_[i].lanes = Sum::Lanes{labels[i].x, labels[i].y, labels[i].z, 1};
    total_.lanes += labels_[i].lanes;
  }
}

ThresholdChoice VarianceSplitter::Best(std::span<const int16_t> values,
                                       int min_side) {
  // Which bins are in use, a bit each: most nodes have far fewer samples than
  // there are bins.
  std::array<uint64_t, (kBins + 63) / 64> in_use{};
  for (size_t i = 0; i < values.size(); ++i) {
    const size_t bin = static_cast<size_t>(values[i] + 255);
    in_use[bin / 64] |= uint64_t{1} << (bin % 64);
    bins_[bin].lanes += labels_[i].lanes;
  }
  Sweep sweep(total_, min_side);
  for (size_t word = 0; word < in_use.size(); ++word) {
    for (uint64_t bits = in_use[word]; bits != 0; bits &= bits - 1) {
      const size_t bin =
          64 * word + static_cast<size_t>(std::countr_zero(bits));
      sweep.Add(bins_[bin], static_cast<int>(bin) - 255);
      bins_[bin] = Sum{};
    }
  }
  return sweep.Best();
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

EntropySplitter::Range EntropySplitter::Fill(std::span<const int16_t> values) {
  Range range{kBins, -1};
  for (size_t i = 0; i < values.size(); ++i) {
    const int bin = values[i] + 255;
    range.low = std::min(range.low, bin);
    range.high = std::max(range.high, bin);
    Moments& m = bins_[static_cast<size_t>(bin)];
    const auto [x, y, z] = labels_[i];
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
                                      int min_side) {
  const auto [low, high] = Fill(values);
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

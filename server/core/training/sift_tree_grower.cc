#include "server/core/training/sift_tree_grower.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>

#include "common/base/random.h"

namespace treeline::training {
namespace {

// Objectives are computed on at most so many samples of a node.
constexpr size_t kMaxSplitSamples = 2000;
// Of splits that are balanced to this, the one over the widest spread wins:
// medians balance nearly every dimension, and a wide one is seldom mistaken.
constexpr double kBalanceTolerance = 0.1;

struct Split {
  int dimension = 0;
  int threshold = 0;  // of the value less 128
};

class Grower {
 public:
  Grower(const SiftSamples& samples, std::span<const Label> position,
         std::vector<uint32_t> chosen, const SiftTrainingOptions& options,
         int tree, const std::stop_token& stop)
      : samples_(samples),
        position_(position),
        order_(std::move(chosen)),
        options_(options),
        tree_(tree),
        stop_(stop) {}

  GrownSiftTree Grow() {
    Grow(0, order_.size(), 0, 1);
    return std::move(grown_);
  }

 private:
  void Grow(size_t begin, size_t end, int depth, uint64_t path) {
    Split split;
    if (stop_.stop_requested() || IsLeaf(begin, end, depth) ||
        !FindSplit(begin, end, depth, path, split)) {
      AddLeaf(begin, end);
      return;
    }
    const auto middle = std::stable_partition(
        order_.begin() + static_cast<std::ptrdiff_t>(begin),
        order_.begin() + static_cast<std::ptrdiff_t>(end), [&](uint32_t s) {
          return ValueOf(s, split.dimension) <= split.threshold;
        });
    const size_t right = static_cast<size_t>(middle - order_.begin());
    const size_t self = grown_.nodes.size();
    grown_.nodes.emplace_back();
    Grow(begin, right, depth + 1, path * 2);
    grown_.nodes[self] = forest::Node::Split(
        {.dx = static_cast<int16_t>(split.dimension)}, split.threshold,
        static_cast<uint32_t>(grown_.nodes.size() - self));
    Grow(right, end, depth + 1, path * 2 + 1);
  }

  int16_t ValueOf(uint32_t sample, int dimension) const {
    const auto& values = samples_.descriptor[sample].values;
    return static_cast<int16_t>(values[static_cast<size_t>(dimension)] - 128);
  }

  bool IsLeaf(size_t begin, size_t end, int depth) const {
    if (end - begin <= static_cast<size_t>(options_.leaf_samples) ||
        depth >= options_.max_depth) {
      return true;
    }
    const int32_t first = samples_.point[order_[begin]];
    return std::all_of(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                       order_.begin() + static_cast<std::ptrdiff_t>(end),
                       [&](uint32_t s) { return samples_.point[s] == first; });
  }

  bool FindSplit(size_t begin, size_t end, int depth, uint64_t path,
                 Split& split) {
    const size_t count = end - begin;
    const size_t used = std::min(count, kMaxSplitSamples);
    subset_.resize(used);
    labels_.resize(used);
    values_.resize(used);
    const Label origin =
        position_[static_cast<size_t>(samples_.point[order_[begin]])];
    for (size_t i = 0; i < used; ++i) {
      subset_[i] = order_[begin + i * count / used];
      const Label& p =
          position_[static_cast<size_t>(samples_.point[subset_[i]])];
      labels_[i] = {p.x - origin.x, p.y - origin.y, p.z - origin.z};
    }
    splitter_.SetLabels(labels_);
    base::Random random(options_.seed,
                        base::MixBits(static_cast<uint64_t>(tree_) + 1) ^ path);
    bool found = false;
    double best = 0;
    for (int c = 0; c < options_.split_candidates; ++c) {
      const int dimension = static_cast<int>(
          random.NextBelow(features::SiftDescriptor::kDimensions));
      for (size_t i = 0; i < used; ++i) {
        values_[i] = ValueOf(subset_[i], dimension);
      }
      int threshold = 0;
      const double score = depth < options_.balanced_levels
                               ? BalancedScore(threshold)
                               : VarianceScore(threshold);
      if (score > best) {
        best = score;
        split = {dimension, threshold};
        found = true;
      }
    }
    return found;
  }

  // The threshold nearest the median, and how good it is: above 1 if it is
  // balanced.
  double BalancedScore(int& threshold) const {
    std::array<int, 256> histogram{};
    double sum = 0;
    double squares = 0;
    for (const int16_t value : values_) {
      ++histogram[static_cast<size_t>(value + 128)];
      sum += value;
      squares += double{1} * value * value;
    }
    const int total = static_cast<int>(values_.size());
    int left = 0;
    int best_excess = total;
    for (int bin = 0; bin < 256; ++bin) {
      left += histogram[static_cast<size_t>(bin)];
      const int excess = std::abs(2 * left - total);
      if (excess < best_excess) {
        best_excess = excess;
        threshold = bin - 128;
      }
    }
    const double imbalance = static_cast<double>(best_excess) / total;
    if (imbalance > kBalanceTolerance) return 1 - imbalance;
    const double mean = sum / total;
    return 1 + std::sqrt(std::max(0.0, squares / total - mean * mean));
  }

  double VarianceScore(int& threshold) {
    const ThresholdChoice choice = splitter_.Best(values_, 1);
    threshold = choice.threshold;
    return choice.gain;
  }

  void AddLeaf(size_t begin, size_t end) {
    std::map<int32_t, std::vector<uint32_t>> samples_of;
    for (size_t i = begin; i < end; ++i) {
      samples_of[samples_.point[order_[i]]].push_back(order_[i]);
    }
    std::vector<std::pair<int32_t, std::vector<uint32_t>>> points(
        samples_of.begin(), samples_of.end());
    std::ranges::stable_sort(points, [](const auto& a, const auto& b) {
      return a.second.size() > b.second.size();
    });
    if (points.size() > forest::Node::kMaxModes)
      points.resize(forest::Node::kMaxModes);
    grown_.nodes.push_back(
        forest::Node::Leaf(static_cast<uint32_t>(grown_.modes.size()),
                           static_cast<uint32_t>(points.size())));
    for (const auto& [point, samples] : points) {
      std::array<uint32_t, features::SiftDescriptor::kDimensions> sum{};
      for (const uint32_t s : samples) {
        const auto& values = samples_.descriptor[s].values;
        for (size_t k = 0; k < sum.size(); ++k) sum[k] += values[k];
      }
      GrownSiftTree::Mode mode;
      mode.point = point;
      mode.count = static_cast<uint32_t>(samples.size());
      for (size_t k = 0; k < sum.size(); ++k) {
        mode.descriptor.values[k] =
            static_cast<uint8_t>((sum[k] + mode.count / 2) / mode.count);
      }
      grown_.modes.push_back(mode);
    }
  }

  const SiftSamples& samples_;
  const std::span<const Label> position_;
  std::vector<uint32_t> order_;
  const SiftTrainingOptions& options_;
  const int tree_;
  const std::stop_token& stop_;
  GrownSiftTree grown_;
  // Of the node at hand.
  std::vector<uint32_t> subset_;
  std::vector<Label> labels_;
  std::vector<int16_t> values_;
  VarianceSplitter splitter_;
};

}  // namespace

GrownSiftTree GrowSiftTree(const SiftSamples& samples,
                           std::span<const Label> position,
                           std::vector<uint32_t> chosen,
                           const SiftTrainingOptions& options, int tree,
                           const std::stop_token& stop) {
  return Grower(samples, position, std::move(chosen), options, tree, stop)
      .Grow();
}

}  // namespace treeline::training

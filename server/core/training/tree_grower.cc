#include "server/core/training/tree_grower.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/random.h"
#include "server/core/training/mean_shift.h"

namespace treeline::training {
namespace {

// Open nodes become tasks of their own below this share of the tree's samples.
constexpr size_t kTasksPerTree = 32;

// Lookups in flight at a time: pixels are scattered over all frames, so each
// is a cache miss.
constexpr size_t kLookupsInFlight = 32;

template <typename T>
void AppendTo(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

void TreeSamples::Append(const TreeSamples& other) {
  AppendTo(frame, other.frame);
  AppendTo(x, other.x);
  AppendTo(y, other.y);
  AppendTo(inverse_depth_q12, other.inverse_depth_q12);
  AppendTo(point_in_world, other.point_in_world);
  AppendTo(descriptor, other.descriptor);
}

void AppendNodes(const std::vector<forest::Node>& subtree, uint32_t mode_base,
                 std::vector<forest::Node>& nodes) {
  for (forest::Node node : subtree) {
    if (node.is_leaf()) {
      node = forest::Node::Leaf(node.leaf() + mode_base, node.modes());
    }
    nodes.push_back(node);
  }
}

struct TreeGrower::Workspace {
  VarianceSplitter variance;
  EntropySplitter entropy;
  std::vector<uint32_t> subset;
  std::vector<Label> labels;
  std::vector<int16_t> values;
  std::vector<uint32_t> right_side;
};

TreeGrower::TreeGrower(const TrainingOptions& options, int tree,
                       std::vector<const features::PlanarImage*> images,
                       const TreeSamples& samples)
    : options_(options),
      tree_(tree),
      images_(std::move(images)),
      samples_(samples),
      order_(samples.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
}

void TreeGrower::GrowTop() {
  const size_t task_size = samples_.size() / kTasksPerTree;
  Workspace work;
  std::vector<std::pair<size_t, OpenNode>> waiting;  // index into top_
  top_.emplace_back();
  waiting.push_back({0, OpenNode{0, order_.size(), 0, 1, {}}});
  while (!waiting.empty()) {
    auto [index, node] = std::move(waiting.back());
    waiting.pop_back();
    Split split;
    if (node.end - node.begin <= task_size || IsLeaf(node) ||
        !FindSplit(node, work, split)) {
      top_[index].open = open_.size();
      open_.push_back(std::move(node));
      continue;
    }
    const size_t middle = Partition(node, split, work);
    const size_t left = top_.size();
    top_.resize(left + 2);
    top_[index] = {true, split, left, left + 1, 0};
    waiting.push_back(
        {left, {node.begin, middle, node.depth + 1, node.path * 2, {}}});
    waiting.push_back(
        {left + 1, {middle, node.end, node.depth + 1, node.path * 2 + 1, {}}});
  }
}

void TreeGrower::GrowOpenNode(size_t i, const std::stop_token& stop) {
  Workspace work;
  Grow(open_[i], work, stop, open_[i].grown);
}

void TreeGrower::Grow(const OpenNode& node, Workspace& work,
                      const std::stop_token& stop, GrownTree& grown) {
  Split split;
  if (stop.stop_requested() || IsLeaf(node) || !FindSplit(node, work, split)) {
    MakeLeaf(node, grown);
    return;
  }
  const size_t middle = Partition(node, split, work);
  const size_t self = grown.nodes.size();
  grown.nodes.emplace_back();
  Grow({node.begin, middle, node.depth + 1, node.path * 2, {}}, work, stop,
       grown);
  grown.nodes[self] =
      forest::Node::Split(split.feature, split.threshold,
                          static_cast<uint32_t>(grown.nodes.size() - self));
  Grow({middle, node.end, node.depth + 1, node.path * 2 + 1, {}}, work, stop,
       grown);
}

bool TreeGrower::IsLeaf(const OpenNode& node) const {
  const size_t count = node.end - node.begin;
  if (node.depth >= options_.max_depth ||
      count < 2 * static_cast<size_t>(options_.min_leaf_samples)) {
    return true;
  }
  geometry::Vec3 sum;
  double squares = 0;
  const Label origin = samples_.point_in_world[order_[node.begin]];
  for (size_t i = node.begin; i < node.end; ++i) {
    const Label& p = samples_.point_in_world[order_[i]];
    const geometry::Vec3 v{p.x - origin.x, p.y - origin.y, p.z - origin.z};
    sum = sum + v;
    squares += geometry::SquaredNorm(v);
  }
  const double n = static_cast<double>(count);
  const double variance = squares / n - geometry::SquaredNorm(sum / n);
  return variance <= options_.min_spread_m * options_.min_spread_m;
}

bool TreeGrower::FindSplit(const OpenNode& node, Workspace& work,
                           Split& split) const {
  const size_t count = node.end - node.begin;
  const size_t used =
      std::min(count, static_cast<size_t>(options_.max_split_samples));
  work.subset.resize(used);
  work.labels.resize(used);
  work.values.resize(used);
  const Label origin = samples_.point_in_world[order_[node.begin]];
  for (size_t i = 0; i < used; ++i) {
    const uint32_t sample = order_[node.begin + i * count / used];
    const Label& p = samples_.point_in_world[sample];
    work.subset[i] = sample;
    work.labels[i] = {p.x - origin.x, p.y - origin.y, p.z - origin.z};
  }
  base::Random random(
      options_.seed,
      base::MixBits(static_cast<uint64_t>(tree_) + 1) ^ node.path);
  const bool balanced = node.depth < options_.balanced_levels;
  const int max_delta = static_cast<int>(4 * options_.max_offset_px_m);
  const auto draw_delta = [&] {
    return static_cast<int16_t>(static_cast<int>(random.NextBelow(
                                    static_cast<uint32_t>(2 * max_delta + 1))) -
                                max_delta);
  };
  bool found = false;
  double best = 0;
  for (int c = 0; c < options_.split_candidates; ++c) {
    features::PixelDifference feature;
    feature.dx = draw_delta();
    feature.dy = draw_delta();
    feature.c1 = static_cast<uint8_t>(random.NextBelow(3));
    feature.c2 = static_cast<uint8_t>(random.NextBelow(3));
    const uint32_t threshold_sample =
        random.NextBelow(static_cast<uint32_t>(used));
    EvaluateFeature(feature, work.subset, work.values);
    int threshold = work.values[threshold_sample];
    double score = 0;
    if (balanced) {
      score = 1 - BalanceObjective(work.values, threshold);
    } else {
      const int min_side = options_.min_leaf_samples;
      const ThresholdChoice choice =
          options_.objective == SplitObjective::kVariance
              ? work.variance.Best(work.values, work.labels, min_side)
              : work.entropy.Best(work.values, work.labels, min_side);
      threshold = choice.threshold;
      score = choice.gain;
    }
    if (score > best) {
      best = score;
      split = {feature, threshold};
      found = true;
    }
  }
  return found;
}

void TreeGrower::EvaluateFeature(const features::PixelDifference& feature,
                                 std::span<const uint32_t> samples,
                                 std::span<int16_t> values) const {
  const uint8_t* first[kLookupsInFlight];
  const uint8_t* second[kLookupsInFlight];
  for (size_t begin = 0; begin < samples.size(); begin += kLookupsInFlight) {
    const size_t count = std::min(kLookupsInFlight, samples.size() - begin);
    for (size_t i = 0; i < count; ++i) {
      const uint32_t s = samples[begin + i];
      const features::PlanarImage& image = *images_[samples_.frame[s]];
      const int32_t q = samples_.inverse_depth_q12[s];
      const int32_t x = samples_.x[s];
      const int32_t y = samples_.y[s];
      const int32_t x2 = std::clamp(x + features::OffsetPixels(feature.dx, q),
                                    0, image.width() - 1);
      const int32_t y2 = std::clamp(y + features::OffsetPixels(feature.dy, q),
                                    0, image.height() - 1);
      first[i] = image.data() + feature.c1 * image.plane_bytes() +
                 y * image.width() + x;
      second[i] = image.data() + feature.c2 * image.plane_bytes() +
                  y2 * image.width() + x2;
      __builtin_prefetch(first[i]);
      __builtin_prefetch(second[i]);
    }
    for (size_t i = 0; i < count; ++i) {
      values[begin + i] = static_cast<int16_t>(*first[i] - *second[i]);
    }
  }
}

size_t TreeGrower::Partition(const OpenNode& node, const Split& split,
                             Workspace& work) {
  const std::span<uint32_t> order(order_.data() + node.begin,
                                  node.end - node.begin);
  work.values.resize(order.size());
  EvaluateFeature(split.feature, order, work.values);
  work.right_side.clear();
  size_t left = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (work.values[i] <= split.threshold) {
      order[left++] = order[i];
    } else {
      work.right_side.push_back(order[i]);
    }
  }
  std::copy(work.right_side.begin(), work.right_side.end(),
            order.begin() + static_cast<std::ptrdiff_t>(left));
  return node.begin + left;
}

void TreeGrower::MakeLeaf(const OpenNode& node, GrownTree& grown) const {
  const std::span<const uint32_t> samples(order_.data() + node.begin,
                                          node.end - node.begin);
  const uint32_t first = static_cast<uint32_t>(grown.leaves.size());
  if (options_.mode_bandwidth_m > 0 && !samples.empty()) {
    std::vector<Label> points;
    for (uint32_t s : samples) points.push_back(samples_.point_in_world[s]);
    for (const std::vector<size_t>& mode : MeanShiftModes(
             points, options_.mode_bandwidth_m, forest::Node::kMaxModes)) {
      std::vector<uint32_t> of_mode;
      for (size_t i : mode) of_mode.push_back(samples[i]);
      grown.leaves.push_back(MakeMode(of_mode));
    }
  } else {
    grown.leaves.push_back(MakeMode(samples));
  }
  grown.nodes.push_back(forest::Node::Leaf(
      first, static_cast<uint32_t>(grown.leaves.size()) - first));
}

GrownLeaf TreeGrower::MakeMode(std::span<const uint32_t> samples) const {
  GrownLeaf mode;
  mode.count = static_cast<uint32_t>(samples.size());
  const double n = mode.count;
  std::array<int64_t, 64> descriptor{};
  for (uint32_t s : samples) {
    const Label& p = samples_.point_in_world[s];
    mode.mean_in_world = mode.mean_in_world + geometry::Vec3{p.x, p.y, p.z};
    const features::WhtDescriptor& d = samples_.descriptor[s];
    for (size_t k = 0; k < d.values.size(); ++k) descriptor[k] += d.values[k];
  }
  if (mode.count == 0) return mode;
  mode.mean_in_world = mode.mean_in_world / n;
  std::array<double, 6> covariance{};
  for (uint32_t s : samples) {
    const Label& p = samples_.point_in_world[s];
    const geometry::Vec3 v = geometry::Vec3{p.x, p.y, p.z} - mode.mean_in_world;
    const std::array<double, 6> products = {v.x * v.x, v.x * v.y, v.x * v.z,
                                            v.y * v.y, v.y * v.z, v.z * v.z};
    for (size_t k = 0; k < 6; ++k) covariance[k] += products[k];
  }
  for (size_t k = 0; k < 6; ++k) {
    mode.covariance[k] = static_cast<float>(covariance[k] / n);
  }
  for (size_t k = 0; k < descriptor.size(); ++k) {
    mode.descriptor.values[k] = static_cast<int8_t>(
        std::lround(static_cast<double>(descriptor[k]) / n));
  }
  return mode;
}

GrownTree TreeGrower::Assemble() {
  GrownTree tree;
  Emit(0, tree);
  return tree;
}

void TreeGrower::Emit(size_t top_index, GrownTree& tree) {
  const TopNode top = top_[top_index];
  if (!top.is_split) {
    GrownTree& grown = open_[top.open].grown;
    AppendNodes(grown.nodes, static_cast<uint32_t>(tree.leaves.size()),
                tree.nodes);
    AppendTo(tree.leaves, grown.leaves);
    grown = GrownTree{};
    return;
  }
  const size_t self = tree.nodes.size();
  tree.nodes.emplace_back();
  Emit(top.left, tree);
  tree.nodes[self] =
      forest::Node::Split(top.split.feature, top.split.threshold,
                          static_cast<uint32_t>(tree.nodes.size() - self));
  Emit(top.right, tree);
}

}  // namespace treeline::training

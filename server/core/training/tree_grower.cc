#include "server/core/training/tree_grower.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/random.h"
#include "server/core/training/mean_shift.h"
#include "server/core/training/tree_pruner.h"

namespace treeline::training {
namespace {

// Values of features that a round keeps at most: 16 MiB of them.
constexpr size_t kMaxRoundValues = size_t{1} << 23;

// A chunk of a round's nodes has about so many samples.
constexpr size_t kChunkSamples = 4096;

// Samples whose features are fetched ahead.
constexpr size_t kSamplesAhead = 8;

// Lookups in flight at a time: pixels are scattered over all frames, so each
// is a cache miss.
constexpr size_t kLookupsInFlight = 32;

// Samples that walk down a tree at a time.
constexpr size_t kWalksInFlight = 16;

// Splits that fewer samples chose are chosen again when frames join.
constexpr size_t kMinSplitSamples = 20;

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
  std::vector<Label> labels;
  std::vector<int16_t> values;  // of one feature after the other
  std::vector<int16_t> all_values;
  std::vector<uint32_t> right_side;
};

TreeGrower::TreeGrower(const TrainingOptions& options, int tree,
                       std::vector<const features::PlanarImage*> images,
                       std::vector<uint8_t> waits, const TreeSamples& samples)
    : options_(options),
      tree_(tree),
      images_(std::move(images)),
      waits_(std::move(waits)),
      samples_(samples),
      candidates_(static_cast<size_t>(options.split_candidates)),
      blocks_((candidates_ + Block::kFeatures - 1) / Block::kFeatures),
      frame_end_(images_.size(), 0),
      place_(samples.size()) {
  for (uint32_t s = 0; s < samples.size(); ++s) {
    if (waits_[samples.frame[s]] == 0) order_.push_back(s);
  }
  for (const uint16_t frame : samples_.frame) ++frame_end_[frame];
  std::partial_sum(frame_end_.begin(), frame_end_.end(), frame_end_.begin());
  nodes_.emplace_back();
  nodes_.back().end = static_cast<uint32_t>(order_.size());
  if (order_.size() < samples.size()) leaf_of_.resize(samples.size());
}

int64_t TreeGrower::total_work() const {
  return static_cast<int64_t>(order_.size()) * (options_.max_depth + 1);
}

size_t TreeGrower::Used(const Node& node) const {
  return std::min(node.size(), static_cast<size_t>(options_.max_split_samples));
}

uint32_t TreeGrower::UsedSample(const Node& node, size_t i) const {
  const size_t used = Used(node);
  return order_[node.begin +
                (used == node.size() ? i : i * node.size() / used)];
}

bool TreeGrower::BeginRound() {
  for (size_t n = round_.begin; n < round_.end; ++n) {
    const Node& parent = nodes_[n];
    finished_work_ +=
        static_cast<int64_t>(parent.size()) *
        (parent.is_split ? 1 : options_.max_depth + 1 - parent.depth);
    if (!parent.is_split || parent.left != 0) continue;
    Node left;
    left.begin = parent.begin;
    left.end = parent.middle;
    left.depth = static_cast<int8_t>(parent.depth + 1);
    left.path = parent.path * 2;
    Node right = left;
    right.begin = parent.middle;
    right.end = parent.end;
    right.path = parent.path * 2 + 1;
    nodes_[n].left = static_cast<uint32_t>(nodes_.size());
    nodes_.push_back(left);
    nodes_.push_back(right);
  }
  round_ = {round_.end, round_.end};
  chunks_.clear();
  first_slot_.clear();
  size_t slots = 0;
  size_t chunk_samples = kChunkSamples;
  for (; round_.end < nodes_.size(); ++round_.end) {
    const Node& node = nodes_[round_.end];
    const size_t values = (slots + Used(node)) * blocks_ * Block::kFeatures;
    if (slots > 0 && values > kMaxRoundValues) break;
    if (chunk_samples >= kChunkSamples) {
      chunks_.push_back({round_.end, round_.end});
      chunk_samples = 0;
    }
    first_slot_.push_back(static_cast<uint32_t>(slots));
    slots += Used(node);
    chunk_samples += node.size();
    chunks_.back().end = round_.end + 1;
  }
  const size_t nodes = round_.end - round_.begin;
  is_open_.assign(nodes, 0);
  features_.resize(std::max(features_.size(), nodes * blocks_));
  threshold_samples_.resize(
      std::max(threshold_samples_.size(), nodes * candidates_));
  values_.resize(std::max(values_.size(), slots * blocks_ * Block::kFeatures));
  return nodes > 0;
}

void TreeGrower::Prepare(size_t chunk) {
  for (size_t n = chunks_[chunk].begin; n < chunks_[chunk].end; ++n) {
    const Node& node = nodes_[n];
    const size_t index = n - round_.begin;
    is_open_[index] = !IsLeaf(node);
    if (!is_open_[index]) continue;
    DrawFeatures(node, index);
    for (size_t i = 0; i < Used(node); ++i) {
      place_[UsedSample(node, i)] = {
          first_slot_[index] + static_cast<uint32_t>(i),
          static_cast<uint32_t>(index)};
    }
  }
}

bool TreeGrower::IsLeaf(const Node& node) const {
  if (node.depth >= options_.max_depth ||
      node.size() < 2 * static_cast<size_t>(options_.min_leaf_samples)) {
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
  const double n = static_cast<double>(node.size());
  const double variance = squares / n - geometry::SquaredNorm(sum / n);
  return variance <= options_.min_spread_m * options_.min_spread_m;
}

void TreeGrower::DrawFeatures(const Node& node, size_t index_in_round) {
  base::Random random(
      options_.seed,
      base::MixBits(static_cast<uint64_t>(tree_) + 1) ^ node.path);
  const int max_delta = static_cast<int>(4 * options_.max_offset_px_m);
  const auto draw_delta = [&] {
    return static_cast<int16_t>(static_cast<int>(random.NextBelow(
                                    static_cast<uint32_t>(2 * max_delta + 1))) -
                                max_delta);
  };
  const uint32_t used = static_cast<uint32_t>(Used(node));
  for (size_t c = 0; c < candidates_; ++c) {
    features::PixelDifference feature;
    feature.dx = draw_delta();
    feature.dy = draw_delta();
    feature.c1 = static_cast<uint8_t>(random.NextBelow(3));
    feature.c2 = static_cast<uint8_t>(random.NextBelow(3));
    features_[index_in_round * blocks_ + c / Block::kFeatures].Set(
        c % Block::kFeatures, feature);
    threshold_samples_[index_in_round * candidates_ + c] =
        static_cast<uint16_t>(random.NextBelow(used));
  }
}

void TreeGrower::EvaluateFrame(size_t frame) {
  const size_t begin = frame == 0 ? 0 : frame_end_[frame - 1];
  const size_t end = frame_end_[frame];
  const features::PlanarImage& image = *images_[frame];
  for (size_t s = begin; s < end; ++s) {
    if (s + kSamplesAhead < end &&
        place_[s + kSamplesAhead].slot != Place::kNone) {
      const Place& ahead = place_[s + kSamplesAhead];
      const char* features =
          reinterpret_cast<const char*>(&features_[ahead.node * blocks_]);
      for (size_t b = 0; b < blocks_ * sizeof(Block); b += 64) {
        __builtin_prefetch(features + b);
      }
    }
    const Place& place = place_[s];
    if (place.slot == Place::kNone) continue;
    features::EvaluateBlocks(
        std::span(features_).subspan(place.node * blocks_, blocks_), image,
        samples_.x[s], samples_.y[s], samples_.inverse_depth_q12[s],
        std::span(values_).subspan(place.slot * blocks_ * Block::kFeatures,
                                   blocks_ * Block::kFeatures));
  }
}

void TreeGrower::SplitNodes(size_t chunk) {
  Workspace work;
  for (size_t n = chunks_[chunk].begin; n < chunks_[chunk].end; ++n) {
    Node& node = nodes_[n];
    const size_t index = n - round_.begin;
    if (!is_open_[index]) continue;
    const size_t used = Used(node);
    for (size_t i = 0; i < used; ++i) place_[UsedSample(node, i)] = Place{};
    const size_t best = FindSplit(node, index, work);
    node.is_split = best < candidates_;
    if (!node.is_split) continue;
    std::span<const int16_t> values =
        std::span(work.values).subspan(best * used, used);
    if (used < node.size()) {
      work.all_values.resize(node.size());
      EvaluateFeature(node.feature,
                      std::span(order_).subspan(node.begin, node.size()),
                      work.all_values);
      values = work.all_values;
    }
    Partition(node, values, work);
  }
}

void TreeGrower::Transpose(size_t slot, size_t used,
                           std::vector<int16_t>& values) const {
  const size_t stride = blocks_ * Block::kFeatures;
  values.resize(candidates_ * used);
  for (size_t i = 0; i < used; ++i) {
    const int16_t* of_sample = values_.data() + (slot + i) * stride;
    for (size_t c = 0; c < candidates_; ++c) {
      values[c * used + i] = of_sample[c];
    }
  }
}

size_t TreeGrower::FindSplit(Node& node, size_t index_in_round,
                             Workspace& work) const {
  const size_t used = Used(node);
  work.labels.resize(used);
  const Label origin = samples_.point_in_world[order_[node.begin]];
  for (size_t i = 0; i < used; ++i) {
    const Label& p = samples_.point_in_world[UsedSample(node, i)];
    work.labels[i] = {p.x - origin.x, p.y - origin.y, p.z - origin.z};
  }
  work.variance.SetLabels(work.labels);
  work.entropy.SetLabels(work.labels);
  Transpose(first_slot_[index_in_round], used, work.values);
  const bool balanced = node.depth < options_.balanced_levels;
  size_t best = candidates_;
  double best_score = 0;
  for (size_t c = 0; c < candidates_; ++c) {
    const std::span<const int16_t> values =
        std::span(work.values).subspan(c * used, used);
    int threshold = 0;
    double score = 0;
    if (balanced) {
      threshold = values[threshold_samples_[index_in_round * candidates_ + c]];
      score = 1 - BalanceObjective(values, threshold);
    } else {
      const int min_side = options_.min_leaf_samples;
      const ThresholdChoice choice =
          options_.objective == SplitObjective::kVariance
              ? work.variance.Best(values, min_side)
              : work.entropy.Best(values, min_side);
      threshold = choice.threshold;
      score = choice.gain;
    }
    if (score > best_score) {
      best_score = score;
      best = c;
      node.feature =
          features_[index_in_round * blocks_ + c / Block::kFeatures].Get(
              c % Block::kFeatures);
      node.threshold = static_cast<int16_t>(threshold);
    }
  }
  return best;
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

void TreeGrower::Partition(Node& node, std::span<const int16_t> values,
                           Workspace& work) {
  const std::span<uint32_t> order(order_.data() + node.begin, node.size());
  work.right_side.clear();
  size_t left = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (values[i] <= node.threshold) {
      order[left++] = order[i];
    } else {
      work.right_side.push_back(order[i]);
    }
  }
  std::copy(work.right_side.begin(), work.right_side.end(),
            order.begin() + static_cast<std::ptrdiff_t>(left));
  node.middle = node.begin + static_cast<uint32_t>(left);
}

void TreeGrower::AppendModes(const Node& node,
                             std::vector<GrownLeaf>& leaves) const {
  const std::span<const uint32_t> samples(order_.data() + node.begin,
                                          node.size());
  if (options_.mode_bandwidth_m == 0 || samples.empty()) {
    leaves.push_back(MakeMode(samples));
    return;
  }
  std::vector<Label> points;
  for (uint32_t s : samples) points.push_back(samples_.point_in_world[s]);
  for (const std::vector<size_t>& mode : MeanShiftModes(
           points, options_.mode_bandwidth_m, forest::Node::kMaxModes)) {
    std::vector<uint32_t> of_mode;
    for (size_t i : mode) of_mode.push_back(samples[i]);
    leaves.push_back(MakeMode(of_mode));
  }
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

GrownTree TreeGrower::Assemble() const {
  std::vector<uint32_t> counts;
  for (const Node& node : nodes_) {
    if (!node.is_split && node.size() > 0) {
      counts.push_back(static_cast<uint32_t>(node.size()));
    }
  }
  // Modes are found in leaves: how many samples they have is not known yet.
  const uint32_t least =
      options_.mode_bandwidth_m > 0
          ? 0
          : LeastKept(counts, static_cast<uint32_t>(options_.min_kept_samples));
  GrownTree tree;
  Emit(0, least, tree);
  return PruneTree(tree, static_cast<uint32_t>(options_.min_kept_samples));
}

bool TreeGrower::StaysSplit(const Node& node) const {
  return node.is_split && node.size() >= kMinSplitSamples;
}

bool TreeGrower::IsLeft(const Node& node, size_t sample) const {
  return features::Evaluate(node.feature, *images_[samples_.frame[sample]],
                            samples_.x[sample], samples_.y[sample],
                            samples_.inverse_depth_q12[sample]) <=
         node.threshold;
}

void TreeGrower::RouteFrame(size_t frame) {
  if (waits_[frame] == 0) return;
  const size_t end = frame_end_[frame];
  // Some at a time, so that one's cache misses do not keep the others waiting.
  std::array<uint32_t, kWalksInFlight> at;
  for (size_t s = frame == 0 ? 0 : frame_end_[frame - 1]; s < end;
       s += kWalksInFlight) {
    const size_t walks = std::min(kWalksInFlight, end - s);
    at.fill(0);
    for (bool moved = true; moved;) {
      moved = false;
      for (size_t i = 0; i < walks; ++i) {
        const Node& node = nodes_[at[i]];
        if (!StaysSplit(node)) continue;
        at[i] = node.left + (IsLeft(node, s + i) ? 0 : 1);
        moved = true;
      }
    }
    std::copy_n(at.begin(), walks,
                leaf_of_.begin() + static_cast<std::ptrdiff_t>(s));
  }
}

void TreeGrower::Join() {
  std::vector<uint32_t> leaves;
  std::vector<uint32_t> waiting = {0};
  while (!waiting.empty()) {
    const uint32_t n = waiting.back();
    waiting.pop_back();
    Node& node = nodes_[n];
    if (StaysSplit(node)) {
      waiting.push_back(node.left + 1);
      waiting.push_back(node.left);
    } else {
      leaves.push_back(n);
      for (size_t i = node.begin; i < node.end; ++i) leaf_of_[order_[i]] = n;
    }
  }
  // What is cut off stays in nodes_, without samples and out of reach.
  for (Node& node : nodes_) {
    if (!StaysSplit(node)) {
      node.is_split = false;
      node.left = 0;
    }
    node.begin = node.end = 0;
  }
  for (const uint32_t leaf : leaf_of_) ++nodes_[leaf].end;
  uint32_t begin = 0;
  for (const uint32_t leaf : leaves) {
    Node& node = nodes_[leaf];
    node.begin = begin;
    begin += node.end;
    node.end = node.begin;
  }
  order_.resize(samples_.size());
  for (uint32_t s = 0; s < order_.size(); ++s) {
    order_[nodes_[leaf_of_[s]].end++] = s;
  }
  leaf_of_ = {};
  round_ = {};
  finished_work_ = 0;
}

void TreeGrower::Emit(size_t n, uint32_t least, GrownTree& tree) const {
  const Node& node = nodes_[n];
  const size_t self = tree.nodes.size();
  tree.nodes.emplace_back();
  if (!node.is_split) {
    const size_t first = tree.leaves.size();
    if (node.size() < least) {
      // It is left out, so what it would be does not matter.
      tree.leaves.emplace_back();
      tree.leaves.back().count = static_cast<uint32_t>(node.size());
    } else {
      AppendModes(node, tree.leaves);
    }
    tree.nodes[self] =
        forest::Node::Leaf(static_cast<uint32_t>(first),
                           static_cast<uint32_t>(tree.leaves.size() - first));
    return;
  }
  Emit(node.left, least, tree);
  tree.nodes[self] =
      forest::Node::Split(node.feature, node.threshold,
                          static_cast<uint32_t>(tree.nodes.size() - self));
  Emit(node.left + 1, least, tree);
}

}  // namespace treeline::training

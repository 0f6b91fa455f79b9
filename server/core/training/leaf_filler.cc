#include "server/core/training/leaf_filler.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include "server/core/forest/backtracking.h"
#include "server/core/training/quantize_forest.h"
#include "server/core/training/tree_pruner.h"

namespace treeline::training {
namespace {

// Samples within this distance of a mode's mean belong to it (m).
constexpr double kModeRadius_m = 0.1;
// Modes a leaf keeps, those with most samples.
constexpr size_t kMaxModes = 16;
// A mode of so many samples learns no more from others; sums do not overflow.
constexpr uint32_t kMaxSamples = 1 << 22;

std::array<double, 6> Products(geometry::Vec3 v) {
  return {v.x * v.x, v.x * v.y, v.x * v.z, v.y * v.y, v.y * v.z, v.z * v.z};
}

}  // namespace

LeafFiller::Mode::Mode(const GrownLeaf& leaf)
    : count_(leaf.count), confirmed_(leaf.count) {
  const double n = leaf.count;
  sum_ = n * leaf.mean_in_world;
  const std::array<double, 6> square = Products(leaf.mean_in_world);
  for (size_t k = 0; k < 6; ++k) {
    products_[k] = n * (static_cast<double>(leaf.covariance[k]) + square[k]);
  }
  for (size_t k = 0; k < descriptor_.size(); ++k) {
    descriptor_[k] =
        static_cast<int32_t>(leaf.count) * leaf.descriptor.values[k];
  }
}

void LeafFiller::Mode::Add(geometry::Vec3 point,
                           const features::WhtDescriptor& descriptor) {
  if (confirmed_ < kMaxSamples) ++confirmed_;
  if (count_ >= kMaxSamples) return;
  ++count_;
  sum_ = sum_ + point;
  const std::array<double, 6> square = Products(point);
  for (size_t k = 0; k < 6; ++k) products_[k] += square[k];
  for (size_t k = 0; k < descriptor_.size(); ++k) {
    descriptor_[k] += descriptor.values[k];
  }
}

bool LeafFiller::Mode::Yields() {
  if (confirmed_ <= 1) return true;
  --confirmed_;
  return false;
}

GrownLeaf LeafFiller::Mode::ToLeaf() const {
  GrownLeaf leaf;
  leaf.count = count_;
  leaf.mean_in_world = mean();
  const std::array<double, 6> square = Products(leaf.mean_in_world);
  for (size_t k = 0; k < 6; ++k) {
    leaf.covariance[k] = static_cast<float>(products_[k] / count_ - square[k]);
  }
  // Rounding must not make a variance negative.
  for (const size_t k : {0u, 3u, 5u}) {
    leaf.covariance[k] = std::max(leaf.covariance[k], 0.0f);
  }
  for (size_t k = 0; k < descriptor_.size(); ++k) {
    leaf.descriptor.values[k] = static_cast<int8_t>(
        std::lround(static_cast<double>(descriptor_[k]) / count_));
  }
  return leaf;
}

LeafFiller::LeafFiller(const forest::ForestView& base, Refill refill,
                       size_t max_gathered)
    : base_(base),
      max_gathered_(max_gathered),
      places_(base.nodes.begin(), base.nodes.end()),
      modes_(static_cast<size_t>(base.trees())) {
  for (size_t t = 0; t < modes_.size(); ++t) {
    for (size_t i = base.tree_offsets[t]; i < base.tree_offsets[t + 1]; ++i) {
      if (!places_[i].is_leaf()) continue;
      places_[i] =
          forest::Node::Leaf(static_cast<uint32_t>(i - base.tree_offsets[t]));
    }
    modes_[t].resize(base.tree(static_cast<int>(t)).size());
    if (refill != Refill::kExtend) continue;
    const GrownTree old = GrownTreeOf(base, static_cast<int>(t));
    for (size_t i = 0; i < old.nodes.size(); ++i) {
      const forest::Node& node = old.nodes[i];
      for (uint32_t k = 0; node.is_leaf() && k < node.modes(); ++k) {
        modes_[t][i].emplace_back(old.leaves[node.leaf() + k]);
      }
    }
  }
}

RoutedSamples LeafFiller::Route(int tree, const features::PlanarImage& image,
                                TreeSamples samples) const {
  RoutedSamples routed;
  const std::vector<int32_t> x(samples.x.begin(), samples.x.end());
  const std::vector<int32_t> y(samples.y.begin(), samples.y.end());
  routed.leaf.resize(x.size());
  const size_t t = static_cast<size_t>(tree);
  forest::VisitLeaves(std::span(places_).subspan(
                          base_.tree_offsets[t],
                          base_.tree_offsets[t + 1] - base_.tree_offsets[t]),
                      image, {x, y, samples.inverse_depth_q12}, 1, routed.leaf);
  routed.point = std::move(samples.point_in_world);
  routed.descriptor = std::move(samples.descriptor);
  return routed;
}

void LeafFiller::AddToNearest(geometry::Vec3 point,
                              const features::WhtDescriptor& descriptor,
                              std::vector<Mode>& modes) const {
  double nearest = kModeRadius_m * kModeRadius_m;
  Mode* chosen = nullptr;
  for (Mode& mode : modes) {
    const double distance = geometry::SquaredNorm(mode.mean() - point);
    if (distance < nearest) {
      nearest = distance;
      chosen = &mode;
    }
  }
  if (chosen != nullptr) {
    chosen->Add(point, descriptor);
    return;
  }
  const Mode own(GrownLeaf{point, {}, 1, descriptor});
  if (max_gathered_ == 0 || modes.size() < max_gathered_) {
    // No room for more than may come.
    if (max_gathered_ > 0 && modes.size() == modes.capacity()) {
      modes.reserve(
          std::min(max_gathered_, std::max<size_t>(1, 2 * modes.size())));
    }
    modes.push_back(own);
    return;
  }
  Mode& least = *std::ranges::min_element(modes, {}, &Mode::confirmed);
  if (least.Yields()) least = own;
}

void LeafFiller::Add(int tree, const RoutedSamples& samples,
                     const geometry::Rigid3& world_from_points) {
  std::vector<std::vector<Mode>>& modes = modes_[static_cast<size_t>(tree)];
  for (size_t i = 0; i < samples.size(); ++i) {
    const Label& p = samples.point[i];
    AddToNearest(world_from_points * geometry::Vec3{p.x, p.y, p.z},
                 samples.descriptor[i], modes[samples.leaf[i]]);
  }
}

void LeafFiller::Empty(int tree) {
  for (std::vector<Mode>& of_leaf : modes_[static_cast<size_t>(tree)]) {
    of_leaf.clear();
  }
}

void LeafFiller::KeepLargest(const std::vector<Mode>& modes,
                             std::vector<const Mode*>& kept) {
  kept.clear();
  for (const Mode& mode : modes) kept.push_back(&mode);
  std::ranges::stable_sort(kept, std::greater<>(), &Mode::count);
  if (kept.size() > kMaxModes) kept.resize(kMaxModes);
}

GrownTree LeafFiller::Assemble(int tree, uint32_t min_samples) const {
  const std::vector<std::vector<Mode>>& modes =
      modes_[static_cast<size_t>(tree)];
  std::vector<const Mode*> kept;
  uint32_t least = min_samples;
  if (min_samples > 1) {
    std::vector<uint32_t> counts;
    for (const std::vector<Mode>& of_leaf : modes) {
      KeepLargest(of_leaf, kept);
      for (const Mode* mode : kept) counts.push_back(mode->count());
    }
    least = LeastKept(counts, min_samples);
  }
  return TreeWithModes(base_.tree(tree), [&](size_t node) {
    KeepLargest(modes[node], kept);
    std::vector<GrownLeaf> leaves;
    for (const Mode* mode : kept) {
      if (mode->count() >= least) leaves.push_back(mode->ToLeaf());
    }
    return leaves;
  });
}

}  // namespace treeline::training

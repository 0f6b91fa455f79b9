// Leaves of a forest whose splits stay, filled with samples as they come
// (thesis 7.2.2; Cavallari et al., "On-the-fly adaptation of regression
// forests", 2017).
#ifndef SERVER_CORE_TRAINING_LEAF_FILLER_H_
#define SERVER_CORE_TRAINING_LEAF_FILLER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/geometry/rigid3.h"
#include "server/core/forest/forest.h"
#include "server/core/training/tree_grower.h"

namespace treeline::training {

enum class Refill {
  kExtend,  // leaves keep what they know: more frames of the same scene
  kAdapt    // leaves forget: another scene
};

// Samples that one frame sends down one tree; slot i belongs to sample i.
struct RoutedSamples {
  std::vector<uint32_t> leaf;  // the leaf's node, within the tree
  // In a frame that LeafFiller::Add is told.
  std::vector<Label> point;
  std::vector<features::WhtDescriptor> descriptor;

  size_t size() const { return leaf.size(); }
};

// Gathers the samples of each leaf in modes: samples that lie near each other,
// each with its mean, covariance and mean descriptor. A leaf of the result has
// up to 16 modes, those with most samples.
class LeafFiller {
 public:
  // `base` must outlive it. max_gathered: modes that a leaf gathers at most, 16
  // or more, so that memory does not grow with the number of samples; 0: as
  // many as there are. Where a leaf is full, a sample apart from its modes
  // counts against the one that was confirmed least, until that is given up for
  // one of its own (as in Misra and Gries, "Finding repeated elements", 1982):
  // what is seen often stays.
  LeafFiller(const forest::ForestView& base, Refill refill,
             size_t max_gathered);

  int trees() const { return base_.trees(); }

  // Where a frame's samples for `tree` come to. `image` is the frame's colour.
  // Thread-safe.
  RoutedSamples Route(int tree, const features::PlanarImage& image,
                      TreeSamples samples) const;

  // Adds samples that were routed down `tree`; their order matters.
  // world_from_points: where the frame of their points lies. Trees may be
  // filled on threads of their own.
  void Add(int tree, const RoutedSamples& samples,
           const geometry::Rigid3& world_from_points = {});

  // As if none had been added to `tree`, nor anything been there at first.
  void Empty(int tree);

  // A tree as it is now: leaves that nothing reached, and the splits above
  // them, are left out; without leaves if nothing reached any. Modes of fewer
  // than `min_samples` samples are left out as PruneTree does.
  GrownTree Assemble(int tree, uint32_t min_samples = 1) const;

 private:
  // Samples of a leaf that lie near each other, as sums.
  class Mode {
   public:
    explicit Mode(const GrownLeaf& leaf);
    geometry::Vec3 mean() const { return sum_ / count_; }
    uint32_t count() const { return count_; }
    void Add(geometry::Vec3 point, const features::WhtDescriptor& descriptor);
    // Whether a sample elsewhere may take its place.
    bool Yields();
    uint32_t confirmed() const { return confirmed_; }
    GrownLeaf ToLeaf() const;

   private:
    uint32_t count_ = 0;
    uint32_t confirmed_ = 0;
    geometry::Vec3 sum_;
    std::array<double, 6> products_{};
    std::array<int32_t, 64> descriptor_{};
  };

  static void KeepLargest(const std::vector<Mode>& modes,
                          std::vector<const Mode*>& kept);
  void AddToNearest(geometry::Vec3 point,
                    const features::WhtDescriptor& descriptor,
                    std::vector<Mode>& modes) const;

  const forest::ForestView base_;
  const size_t max_gathered_;
  // The nodes of all trees, in which leaves carry their own place in the tree.
  std::vector<forest::Node> places_;
  // By tree and node; empty but for leaves.
  std::vector<std::vector<std::vector<Mode>>> modes_;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_LEAF_FILLER_H_

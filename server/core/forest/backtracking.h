// Backtracking prediction (thesis 4.2.4, Algorithm 3), many samples at once.
#ifndef SERVER_CORE_FOREST_BACKTRACKING_H_
#define SERVER_CORE_FOREST_BACKTRACKING_H_

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/core/features/planar_image.h"
#include "server/core/features/walsh_hadamard.h"
#include "server/core/forest/forest.h"

namespace treeline::forest {

// N_max of Algorithm 3 is at most this.
inline constexpr int kMaxBacktrackingLeaves = 32;
inline constexpr uint32_t kNoLeaf = 0xffffffffu;

// The pixels to predict for: slot i of each array belongs to sample i.
struct SampleView {
  std::span<const int32_t> x;  // inside the image
  std::span<const int32_t> y;
  std::span<const int32_t> inverse_depth_q12;

  size_t size() const { return x.size(); }
};

// Walks every sample down one tree to `leaves_per_sample` (1 to 32) leaves: the
// first by the split tests, then again and again from the unvisited sibling
// whose split the sample passed most narrowly (|feature - threshold|; ties go
// to the node nearest the root's left edge). out[i * leaves_per_sample + k] is
// the lo of the k-th leaf of sample i (see Node::FirstMode and Node::Modes), or
// kNoLeaf where the tree has fewer.
void VisitLeaves(std::span<const Node> tree, const features::PlanarImage& image,
                 const SampleView& samples, int leaves_per_sample,
                 std::span<uint32_t> out);

// One prediction: of the leaves visited in a tree, the mode whose mean
// descriptor is nearest.
struct LeafMatch {
  uint32_t leaf = kNoLeaf;  // the mode's index: payloads[leaf]
  // Squared descriptor distance.
  int32_t distance = 0;
};

// How many leaves a sample visits in each tree.
struct BacktrackingOptions {
  // N_max of Algorithm 3, in [1, 32].
  int leaves = 6;
  // Fewer than that: a sample visits so many first, and `leaves` only if the
  // best match of all trees is further than this from its descriptor. Thesis
  // 7.2.1 proposes to choose N_max by need.
  int first_leaves = kMaxBacktrackingLeaves;
  int32_t good_squared_distance = 0;
};

// Working memory, kept between calls.
struct BacktrackingScratch {
  std::vector<uint32_t> leaves;
  // The samples that look further, and what is found for them.
  std::vector<uint32_t> index;
  std::vector<int32_t> x;
  std::vector<int32_t> y;
  std::vector<int32_t> inverse_depth_q12;
  std::vector<features::WhtDescriptor> descriptors;
  std::vector<LeafMatch> matches;
};

// For each sample i, the best match of each tree in matches[i * trees + t],
// sorted by distance within a sample (ties by tree): matches[i * trees] is
// Algorithm 3's answer over the whole forest. Returns early, with the rest of
// `matches` unset, once `stop` is requested.
void PredictLeaves(const ForestView& forest, const features::PlanarImage& image,
                   const SampleView& samples,
                   std::span<const features::WhtDescriptor> descriptors,
                   const BacktrackingOptions& options,
                   const std::stop_token& stop, BacktrackingScratch& scratch,
                   std::span<LeafMatch> matches);

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_BACKTRACKING_H_

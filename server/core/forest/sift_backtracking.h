// Backtracking prediction (thesis 4.2.4, Algorithm 3) in forests on SIFT
// descriptors.
#ifndef SERVER_CORE_FOREST_SIFT_BACKTRACKING_H_
#define SERVER_CORE_FOREST_SIFT_BACKTRACKING_H_

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/core/features/sift_descriptor.h"
#include "server/core/forest/backtracking.h"
#include "server/core/forest/forest.h"

namespace treeline::forest {

struct SiftSearchOptions {
  // N_max of Algorithm 3: leaves visited in each tree, in [1, 32].
  int leaves_per_tree = 6;
  // Modes nearer than this to the best one are the same place seen again, and
  // no competition to it (world units).
  double same_place = 0;
};

// What the forest says about one descriptor.
struct SiftMatch {
  // Of all modes of all leaves visited, the one of the nearest mean
  // descriptor (ties go to the smaller index); kNoLeaf: none.
  uint32_t mode = kNoLeaf;
  // Squared descriptor distances: of this mode, and of the nearest of the
  // modes visited that lie elsewhere in the scene (kNothingElsewhere: none).
  int32_t distance = 0;
  int32_t distance_elsewhere = 0;

  static constexpr int32_t kNothingElsewhere = 0x7fffffff;
};

// Squared Euclidean distance.
int32_t SquaredDistance(const features::SiftDescriptor& a,
                        const features::SiftDescriptor& b);

// The leaves of one tree that a descriptor reaches, in order: the first by the
// split tests, then again and again from the unvisited sibling whose split was
// passed most narrowly. leaves[k] is the lo of the k-th leaf (see
// Node::FirstMode). Returns how many there are, at most leaves.size() <= 32.
size_t VisitSiftLeaves(std::span<const Node> tree,
                       const features::SiftDescriptor& descriptor,
                       std::span<uint32_t> leaves);

// matches[i] for descriptors[i], of each i in `which`; the others stay as they
// were, and so does the rest once `stop` is requested.
void MatchSift(const ForestView& forest,
               std::span<const features::SiftDescriptor> descriptors,
               std::span<const uint32_t> which,
               const SiftSearchOptions& options, const std::stop_token& stop,
               std::span<SiftMatch> matches);

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_SIFT_BACKTRACKING_H_

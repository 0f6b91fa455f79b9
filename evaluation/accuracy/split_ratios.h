// How evenly a forest's splits divide their samples (thesis Fig. 4.9).
#ifndef EVALUATION_ACCURACY_SPLIT_RATIOS_H_
#define EVALUATION_ACCURACY_SPLIT_RATIOS_H_

#include <array>
#include <cstdint>
#include <vector>

#include "server/core/forest/forest.h"

namespace treeline::accuracy {

inline constexpr int kSplitRatioBins = 20;

// The splits of one level, over all trees.
struct LevelSplits {
  int64_t splits = 0;
  // Splits whose share of samples that go left lies in bin k of equal width;
  // the last bin has its end too.
  std::array<int64_t, kSplitRatioBins> by_left_share{};
};

// By level from the root (0) down. A node's samples are those of the leaves
// below it, as LeafPayload::count has them: a leaf of more than 65535 samples
// counts as 65535, and of a leaf with several modes those that its modes hold.
std::vector<LevelSplits> SplitRatios(const forest::ForestView& forest);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_SPLIT_RATIOS_H_

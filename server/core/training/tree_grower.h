// Grows trees from samples (thesis 4.2.3, Algorithm 2).
#ifndef SERVER_CORE_TRAINING_TREE_GROWER_H_
#define SERVER_CORE_TRAINING_TREE_GROWER_H_

#include <cstdint>
#include <span>
#include <vector>

#include "server/core/features/pixel_difference_blocks.h"
#include "server/core/features/planar_image.h"
#include "server/core/features/walsh_hadamard.h"
#include "server/core/forest/forest.h"
#include "server/core/training/split_objective.h"
#include "server/core/training/training_options.h"

namespace treeline::training {

// The samples of one tree; slot i of each array belongs to sample i.
struct TreeSamples {
  std::vector<uint16_t> frame;  // index into the frames of the tree
  std::vector<int16_t> x;
  std::vector<int16_t> y;
  std::vector<int32_t> inverse_depth_q12;
  std::vector<Label> point_in_world;
  std::vector<features::WhtDescriptor> descriptor;

  size_t size() const { return frame.size(); }
  void Append(const TreeSamples& other);
};

// A mode of a leaf before quantisation.
struct GrownLeaf {
  geometry::Vec3 mean_in_world;
  std::array<float, 6> covariance{};  // xx xy xz yy yz zz, m^2
  uint32_t count = 0;
  features::WhtDescriptor descriptor;
};

// A subtree in depth-first order. Modes (`leaves`, since most leaves have one)
// count from 0 within it.
struct GrownTree {
  std::vector<forest::Node> nodes;
  std::vector<GrownLeaf> leaves;
};

// Appends the nodes of a subtree whose modes will stand behind mode_base
// others.
void AppendNodes(const std::vector<forest::Node>& subtree, uint32_t mode_base,
                 std::vector<forest::Node>& nodes);

// Grows one tree in rounds, so that many trees share the frames and the
// processors: each round splits the nodes that wait, level by level, as many as
// its memory allows.
//
//   while (grower.BeginRound()) {
//     Prepare(c) of each chunk c;         // on any threads
//     EvaluateFrame(f) of each frame f;   // likewise
//     SplitNodes(c) of each chunk c;      // likewise
//   }
//   grower.Assemble();
//
// Frames may wait: a tree is grown without them, and then goes on with them:
//
//   RouteFrame(f) of each frame f;        // on any threads
//   grower.Join();
//   ... rounds as before ...
//   grower.Assemble();
//
// Features are evaluated frame by frame, all features of a sample at once: a
// frame then is in a processor's cache for all of its samples, where a node's
// samples are scattered over all frames. A node's random draws depend on (seed,
// tree, its place in the tree) alone, and so does the tree.
class TreeGrower {
 public:
  // images[f] is the frame f of samples.frame, which ascends; all must outlive
  // the grower. waits[f] is 1 for frames that wait.
  TreeGrower(const TrainingOptions& options, int tree,
             std::vector<const features::PlanarImage*> images,
             std::vector<uint8_t> waits, const TreeSamples& samples);

  // False: the tree is grown.
  bool BeginRound();
  size_t chunks() const { return chunks_.size(); }
  void Prepare(size_t chunk);
  size_t frames() const { return images_.size(); }
  void EvaluateFrame(size_t frame);
  void SplitNodes(size_t chunk);

  // In [0, total_work()]; a sample's way down is as long as the deepest may be.
  int64_t finished_work() const { return finished_work_; }
  int64_t total_work() const;

  // Without small leaves (TrainingOptions::min_kept_samples).
  GrownTree Assemble() const;

  // Sends the samples of a frame that waits down the tree.
  void RouteFrame(size_t frame);
  // Cuts the tree back to splits that enough samples chose, and lets all
  // samples into the leaves that they come to, which are open again.
  void Join();

 private:
  using Block = features::PixelDifferenceBlock;

  // Samples order_[begin, end). There are many of them.
  struct Node {
    uint64_t path = 1;  // 1, then a bit for each turn from the root
    uint32_t begin = 0;
    uint32_t end = 0;
    // Of a split: where the right side's samples begin, and the left child's
    // index in nodes_; the right child is the next one.
    uint32_t middle = 0;
    uint32_t left = 0;
    features::PixelDifference feature;
    int16_t threshold = 0;
    int8_t depth = 0;
    bool is_split = false;

    size_t size() const { return end - begin; }
  };
  // Nodes nodes_[begin, end).
  struct Chunk {
    size_t begin = 0;
    size_t end = 0;
  };
  // Where a sample's features are to be evaluated: for the objective of its
  // node, if it is among those that it is computed on.
  struct Place {
    static constexpr uint32_t kNone = UINT32_MAX;
    uint32_t slot = kNone;  // of the round's values
    uint32_t node = 0;      // of the round
  };
  struct Workspace;

  // Of a node's samples, those that objectives are computed on.
  size_t Used(const Node& node) const;
  uint32_t UsedSample(const Node& node, size_t i) const;
  bool IsLeaf(const Node& node) const;
  void DrawFeatures(const Node& node, size_t index_in_round);
  // Among the node's features, the values of which are left in `work`; else
  // candidates_.
  size_t FindSplit(Node& node, size_t index_in_round, Workspace& work) const;
  // Puts the values of the node's features one feature after the other.
  void Transpose(size_t slot, size_t used, std::vector<int16_t>& values) const;
  void EvaluateFeature(const features::PixelDifference& feature,
                       std::span<const uint32_t> samples,
                       std::span<int16_t> values) const;
  // Reorders the node's samples stably, by what they are at its feature.
  void Partition(Node& node, std::span<const int16_t> values, Workspace& work);
  void AppendModes(const Node& node, std::vector<GrownLeaf>& leaves) const;
  GrownLeaf MakeMode(std::span<const uint32_t> samples) const;
  // Leaves with fewer than `least` samples remain empty.
  void Emit(size_t node, uint32_t least, GrownTree& tree) const;
  bool IsLeft(const Node& node, size_t sample) const;
  // Splits that stay when the frames that waited join.
  bool StaysSplit(const Node& node) const;

  const TrainingOptions& options_;
  const int tree_;
  const std::vector<const features::PlanarImage*> images_;
  const std::vector<uint8_t> waits_;
  const TreeSamples& samples_;
  const size_t candidates_;        // features tried at a node
  const size_t blocks_;            // of features of a node
  std::vector<size_t> frame_end_;  // samples of frame f end here
  std::vector<uint32_t> order_;
  std::vector<Place> place_;       // by sample
  std::vector<Node> nodes_;        // the root, then level by level
  std::vector<uint32_t> leaf_of_;  // by sample, while frames join
  int64_t finished_work_ = 0;

  // Of the round: its nodes, and by node (index in the round) or slot.
  Chunk round_;
  std::vector<Chunk> chunks_;
  std::vector<uint32_t> first_slot_;
  std::vector<uint8_t> is_open_;             // whether a split is sought
  std::vector<Block> features_;              // blocks_ a node
  std::vector<uint16_t> threshold_samples_;  // candidates_ a node
  std::vector<int16_t> values_;              // a block's a slot, blocks_ times
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_TREE_GROWER_H_

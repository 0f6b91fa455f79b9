// Grows trees from samples (thesis 4.2.3, Algorithm 2).
#ifndef SERVER_CORE_TRAINING_TREE_GROWER_H_
#define SERVER_CORE_TRAINING_TREE_GROWER_H_

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

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

// Grows one tree in two steps, so that many trees share the processors evenly:
// GrowTop splits the largest nodes one after the other, then each open node
// that is left may be grown by itself, on any thread, and Assemble puts all
// together. A node's random draws depend on (seed, tree, its place in the
// tree) alone.
class TreeGrower {
 public:
  // images[f] is the frame f of samples.frame; all must outlive the grower.
  TreeGrower(const TrainingOptions& options, int tree,
             std::vector<const features::PlanarImage*> images,
             const TreeSamples& samples);

  void GrowTop();
  size_t open_nodes() const { return open_.size(); }
  size_t open_node_samples(size_t i) const {
    return open_[i].end - open_[i].begin;
  }
  // Returns early, with a useless subtree, once `stop` is requested.
  void GrowOpenNode(size_t i, const std::stop_token& stop);
  GrownTree Assemble();

 private:
  struct Split {
    features::PixelDifference feature;
    int threshold = 0;
  };
  // A node that waits to be split: samples order_[begin, end).
  struct OpenNode {
    size_t begin = 0;
    size_t end = 0;
    int depth = 0;
    uint64_t path = 1;  // 1, then a bit for each turn from the root
    GrownTree grown;
  };
  struct TopNode {
    bool is_split = false;
    Split split;
    size_t left = 0;   // index into top_
    size_t right = 0;  // likewise
    size_t open = 0;   // index into open_, if not a split
  };
  struct Workspace;

  bool IsLeaf(const OpenNode& node) const;
  bool FindSplit(const OpenNode& node, Workspace& work, Split& split) const;
  void EvaluateFeature(const features::PixelDifference& feature,
                       std::span<const uint32_t> samples,
                       std::span<int16_t> values) const;
  // Reorders order_[begin, end) stably; returns where the right side begins.
  size_t Partition(const OpenNode& node, const Split& split, Workspace& work);
  void Grow(const OpenNode& node, Workspace& work, const std::stop_token& stop,
            GrownTree& grown);
  // Appends a leaf with its modes.
  void MakeLeaf(const OpenNode& node, GrownTree& grown) const;
  GrownLeaf MakeMode(std::span<const uint32_t> samples) const;
  void Emit(size_t top_index, GrownTree& tree);

  const TrainingOptions& options_;
  const int tree_;
  const std::vector<const features::PlanarImage*> images_;
  const TreeSamples& samples_;
  std::vector<uint32_t> order_;
  std::vector<TopNode> top_;
  std::vector<OpenNode> open_;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_TREE_GROWER_H_

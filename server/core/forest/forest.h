// Regression forests as flat arrays: what training writes, the model file
// holds and prediction reads.
#ifndef SERVER_CORE_FOREST_FOREST_H_
#define SERVER_CORE_FOREST_FOREST_H_

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/vector3.h"
#include "server/core/features/pixel_difference.h"
#include "server/core/features/sift_descriptor.h"
#include "server/core/features/walsh_hadamard.h"

namespace treeline::forest {

// One node in eight bytes. The nodes of a tree stand in depth-first order: the
// left child follows its parent, the right child is `right_offset` further.
//   split: lo = dx:10 | dy:10 | c1:2 | c2:2;  hi = (threshold + 256):9 |
//          right_offset:23 (> 0)
//   leaf:  lo = first mode:27 | (modes - 1):5;  hi = 0 (right_offset 0)
// A sample goes left if its feature is <= threshold (thesis Eq. 3.6).
//
// In a forest on SIFT descriptors dx is the dimension (0..127) and the feature
// that dimension's value less 128; dy, c1 and c2 are 0.
//
// A leaf has one or more modes (thesis 5.4.4), one after the other in the
// forest's arrays; but for points-lines, one.
struct Node {
  uint32_t lo = 0;
  uint32_t hi = 0;

  static constexpr int kModeBits = 27;
  static constexpr int kMaxDelta = 511;
  static constexpr uint32_t kMaxNodesPerTree = (1u << 23) - 1;

  static constexpr uint32_t kMaxModes = 32;

  static constexpr Node Leaf(uint32_t first_mode, uint32_t modes = 1) {
    return {first_mode | (modes - 1) << kModeBits, 0};
  }
  // threshold in [-256, 255].
  static constexpr Node Split(const features::PixelDifference& feature,
                              int threshold, uint32_t right_offset) {
    return {(static_cast<uint32_t>(feature.dx) & 1023u) |
                (static_cast<uint32_t>(feature.dy) & 1023u) << 10 |
                static_cast<uint32_t>(feature.c1) << 20 |
                static_cast<uint32_t>(feature.c2) << 22,
            static_cast<uint32_t>(threshold + 256) | right_offset << 9};
  }

  constexpr bool is_leaf() const { return right_offset() == 0; }
  constexpr uint32_t leaf() const { return FirstMode(lo); }
  constexpr uint32_t modes() const { return Modes(lo); }
  // The same of a leaf's lo alone.
  static constexpr uint32_t FirstMode(uint32_t leaf_lo) {
    return leaf_lo & ((1u << kModeBits) - 1);
  }
  static constexpr uint32_t Modes(uint32_t leaf_lo) {
    return (leaf_lo >> kModeBits) + 1;
  }
  constexpr uint32_t right_offset() const { return hi >> 9; }
  constexpr int threshold() const { return static_cast<int>(hi & 511u) - 256; }
  constexpr features::PixelDifference feature() const {
    return {static_cast<int16_t>(static_cast<int32_t>(lo << 22) >> 22),
            static_cast<int16_t>(static_cast<int32_t>(lo << 12) >> 22),
            static_cast<uint8_t>((lo >> 20) & 3u),
            static_cast<uint8_t>((lo >> 22) & 3u)};
  }
};
static_assert(sizeof(Node) == 8);

// What a mode of a leaf says about the training samples that reached it, in 20
// bytes.
struct LeafPayload {
  // Mean position: bounds_min + mean / 65535 * (bounds_max - bounds_min).
  std::array<uint16_t, 3> mean{};
  // Covariance about the mean, m^2, upper triangle xx xy xz yy yz zz, each the
  // upper half of a float (bfloat16).
  std::array<uint16_t, 6> covariance{};
  // Number of samples, saturating.
  uint16_t count = 0;
};
static_assert(sizeof(LeafPayload) == 20);

inline uint16_t ToBfloat16(float value) {
  // Round to nearest; NaN and infinity do not occur.
  return static_cast<uint16_t>((std::bit_cast<uint32_t>(value) + 0x8000u) >>
                               16);
}
inline float FromBfloat16(uint16_t value) {
  return std::bit_cast<float>(static_cast<uint32_t>(value) << 16);
}

// A forest whose arrays belong to somebody else (a mapped file, a Forest).
struct ForestView {
  std::span<const Node> nodes;             // all trees, one after the other
  std::span<const uint32_t> tree_offsets;  // trees + 1 entries into nodes
  // One per mode: those that the method has, the other empty.
  std::span<const features::WhtDescriptor> descriptors;
  std::span<const features::SiftDescriptor> sift_descriptors;
  std::span<const LeafPayload> payloads;  // one per mode
  geometry::Vec3 bounds_min_in_world;
  geometry::Vec3 bounds_max_in_world;

  int trees() const { return static_cast<int>(tree_offsets.size()) - 1; }
  std::span<const Node> tree(int t) const {
    const size_t begin = tree_offsets[static_cast<size_t>(t)];
    return nodes.subspan(begin,
                         tree_offsets[static_cast<size_t>(t) + 1] - begin);
  }
  geometry::Vec3 LeafMean(uint32_t leaf) const;

  // DATA_LOSS unless prediction is safe on it: every child lies behind its
  // parent inside the same tree, channels are 0..2 (dimensions 0..127), modes
  // exist, bounds are finite.
  absl::Status Validate() const;
};

// A forest that owns its arrays: fresh from training.
struct Forest {
  std::vector<Node> nodes;
  std::vector<uint32_t> tree_offsets{0};
  std::vector<features::WhtDescriptor> descriptors;
  std::vector<features::SiftDescriptor> sift_descriptors;
  std::vector<LeafPayload> payloads;
  geometry::Vec3 bounds_min_in_world;
  geometry::Vec3 bounds_max_in_world;

  ForestView View() const {
    return {nodes,    tree_offsets,        descriptors,        sift_descriptors,
            payloads, bounds_min_in_world, bounds_max_in_world};
  }
};

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_FOREST_H_

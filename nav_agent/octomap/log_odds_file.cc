#include "nav_agent/octomap/log_odds_file.h"

#include <algorithm>
#include <array>
#include <bit>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline::octree {
namespace {

constexpr int kDepth = 16;      // of OctoMap's trees
constexpr int kBlockLevel = 3;  // a block is a cube of 2^3 voxels each way
constexpr int kBlocks = 1 << (kDepth - kBlockLevel);
constexpr size_t kNodeBytes = 5;  // log-odds, and a bit for each child

using FindBlock = std::function<std::optional<LogOddsBlock>(VoxelIndex)>;

// Nodes depth first; cubes that turn out to be all the same are taken back.
class LogOddsWriter {
 public:
  LogOddsWriter(VoxelIndex lowest, VoxelIndex end, const FindBlock& find)
      : lowest_(lowest), end_(end), find_(find) {}

  void Write() {
    constexpr int kLowest = -kBlocks / 2;
    WriteCube({kLowest, kLowest, kLowest}, kDepth - kBlockLevel);
  }
  const std::string& bytes() const { return bytes_; }
  uint64_t nodes() const { return nodes_; }

 private:
  struct Node {
    bool is_known = false;
    bool is_leaf = false;
    float log_odds = 0;
  };

  // A cube of 2^level blocks.
  Node WriteCube(VoxelIndex block, int level) {
    const int width = 1 << level;
    if (block.x + width <= lowest_.x || block.x >= end_.x ||
        block.y + width <= lowest_.y || block.y >= end_.y ||
        block.z + width <= lowest_.z || block.z >= end_.z) {
      return {};
    }
    if (level == 0) {
      const std::optional<LogOddsBlock> found = find_(block);
      return found ? WriteVoxels(*found, {}, kBlockLevel) : Node{};
    }
    return WriteInner(level + kBlockLevel, [this, block, level](int child) {
      const int half = 1 << (level - 1);
      return WriteCube(
          {block.x + (child & 1) * half, block.y + (child >> 1 & 1) * half,
           block.z + (child >> 2) * half},
          level - 1);
    });
  }

  // A cube of 2^level voxels of a block.
  Node WriteVoxels(const LogOddsBlock& block, VoxelIndex voxel, int level) {
    constexpr int kSide = LogOddsBlock::kSide;
    if (level == 0) {
      const auto column = static_cast<size_t>(voxel.x * kSide + voxel.y);
      if ((block.known[column] >> voxel.z & 1) == 0) return {};
      return WriteLeaf(
          block.log_odds[column * kSide + static_cast<size_t>(voxel.z)]);
    }
    return WriteInner(level, [this, &block, voxel, level](int child) {
      const int half = 1 << (level - 1);
      return WriteVoxels(
          block,
          {voxel.x + (child & 1) * half, voxel.y + (child >> 1 & 1) * half,
           voxel.z + (child >> 2) * half},
          level - 1);
    });
  }

  // Children by write_child(0..7).
  template <typename WriteChild>
  Node WriteInner(int level, const WriteChild& write_child) {
    const size_t begin = bytes_.size();
    const uint64_t nodes_before = nodes_;
    ++nodes_;
    bytes_.append(kNodeBytes, '\0');
    std::array<Node, 8> children;
    int bits = 0;
    bool is_uniform = true;
    Node node;
    for (int i = 0; i < 8; ++i) {
      const Node child = write_child(i);
      children[static_cast<size_t>(i)] = child;
      is_uniform =
          is_uniform && child.is_leaf && child.log_odds == children[0].log_odds;
      if (!child.is_known) continue;
      bits |= 1 << i;
      node.log_odds = node.is_known ? std::max(node.log_odds, child.log_odds)
                                    : child.log_odds;
      node.is_known = true;
    }
    // The root stays, as OctoMap's does.
    if (!node.is_known || (is_uniform && level < kDepth)) {
      bytes_.resize(begin);
      nodes_ = nodes_before;
      return node.is_known ? WriteLeaf(node.log_odds) : Node{};
    }
    PutLogOdds(begin, node.log_odds);
    bytes_[begin + 4] = static_cast<char>(bits);
    return node;
  }

  Node WriteLeaf(float log_odds) {
    ++nodes_;
    const size_t begin = bytes_.size();
    bytes_.append(kNodeBytes, '\0');
    PutLogOdds(begin, log_odds);
    return {.is_known = true, .is_leaf = true, .log_odds = log_odds};
  }

  void PutLogOdds(size_t at, float value) {
    const auto bits = std::bit_cast<uint32_t>(value);
    for (size_t i = 0; i < 4; ++i) {
      bytes_[at + i] = static_cast<char>(bits >> (8 * i) & 0xff);
    }
  }

  VoxelIndex lowest_;
  VoxelIndex end_;
  const FindBlock& find_;
  std::string bytes_;
  uint64_t nodes_ = 0;
};

}  // namespace

absl::StatusOr<std::string> FormatLogOddsOt(double resolution_m,
                                            VoxelIndex lowest, VoxelIndex end,
                                            const FindBlock& find) {
  if (!(resolution_m > 0)) {
    return absl::InvalidArgumentError("an OctoMap's resolution is positive");
  }
  if (std::min({lowest.x, lowest.y, lowest.z}) < -kBlocks / 2 ||
      std::max({end.x, end.y, end.z}) > kBlocks / 2) {
    return absl::InvalidArgumentError(
        "an OctoMap holds only the 2^15 voxels next to the origin each way");
  }
  LogOddsWriter writer(lowest, end, find);
  writer.Write();
  return absl::StrCat(
      "# Octomap OcTree file\n# (feel free to add / change comments, but leave "
      "the first line as it is!)\n#\nid OcTree\nsize ",
      writer.nodes(), "\nres ", absl::StrFormat("%.9g", resolution_m),
      "\ndata\n", writer.bytes());
}

}  // namespace treeline::octree

#include "nav_agent/octomap/octree_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::octree {
namespace {

constexpr int kDepth = 16;  // of OctoMap's trees: 2^16 voxels each way
constexpr int kCenter = 1 << (kDepth - 1);  // the key of voxel 0
constexpr absl::string_view kBinaryHead = "# Octomap OcTree binary file";
constexpr absl::string_view kFullHead = "# Octomap OcTree file";
// OctoMap's clamping thresholds, as log-odds.
constexpr float kFreeLogOdds = -2.0F;
constexpr float kOccupiedLogOdds = 3.5F;

struct Head {
  bool binary = true;
  bool colored = false;
  uint64_t nodes = 0;
  double resolution_m = 0;
};

// A cube of 2^level voxels each way; keys are of its lowest voxel.
struct Leaf {
  uint16_t x = 0;
  uint16_t y = 0;
  uint16_t z = 0;
  uint8_t level = 0;
  bool occupied = false;
};

absl::Status FileError(absl::string_view name, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(name, ": ", what));
}

// The line that `rest` begins with, taken from it.
absl::string_view TakeLine(absl::string_view& rest) {
  const size_t end = rest.find('\n');
  const absl::string_view line = rest.substr(0, end);
  rest = end == absl::string_view::npos ? "" : rest.substr(end + 1);
  return absl::StripAsciiWhitespace(line);
}

absl::Status ReadEntry(absl::string_view line, absl::string_view name,
                       Head& head) {
  const std::vector<absl::string_view> words =
      absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  if (words.size() < 2) return absl::OkStatus();
  if (words[0] == "id") {
    head.colored = words[1] == "ColorOcTree";
    if (words[1] != "OcTree" && !(head.colored && !head.binary)) {
      return FileError(name,
                       absl::StrCat("a tree of kind '", words[1].substr(0, 40),
                                    "'; only OcTree, and ColorOcTree in .ot "
                                    "files, are read"));
    }
  } else if (words[0] == "size") {
    if (!absl::SimpleAtoi(words[1], &head.nodes)) {
      return FileError(name, "its 'size' is not a number");
    }
  } else if (words[0] == "res") {
    if (!absl::SimpleAtod(words[1], &head.resolution_m) ||
        !(head.resolution_m >= 1e-3 && head.resolution_m <= 10)) {
      return FileError(name, "its 'res' is not a number from 0.001 to 10 (m)");
    }
  }
  return absl::OkStatus();
}

// Takes the head from `rest`.
absl::StatusOr<Head> TakeHead(absl::string_view& rest, absl::string_view name) {
  Head head;
  const absl::string_view magic = TakeLine(rest);
  if (magic == kFullHead) {
    head.binary = false;
  } else if (magic != kBinaryHead) {
    return FileError(name, absl::StrCat("this is not an OctoMap: it does not "
                                        "begin with '",
                                        kBinaryHead, "' or '", kFullHead, "'"));
  }
  bool has_size = false;
  bool has_id = false;
  while (!rest.empty()) {
    const absl::string_view line = TakeLine(rest);
    if (line == "data") {
      if (!has_id || !has_size || head.resolution_m == 0) {
        return FileError(name, "its head lacks 'id', 'size' or 'res'");
      }
      return head;
    }
    has_size = has_size || absl::StartsWith(line, "size");
    has_id = has_id || absl::StartsWith(line, "id");
    TL_RETURN_IF_ERROR(ReadEntry(line, name, head));
  }
  return FileError(name, "its head does not end with 'data'");
}

// The box of the leaves seen.
class LeafBounds {
 public:
  void Visit(const Leaf& leaf) {
    const int width = 1 << leaf.level;
    low_ = {std::min<int>(low_.x, leaf.x), std::min<int>(low_.y, leaf.y),
            std::min<int>(low_.z, leaf.z)};
    high_ = {std::max(high_.x, leaf.x + width),
             std::max(high_.y, leaf.y + width),
             std::max(high_.z, leaf.z + width)};
  }
  VoxelIndex low() const { return high_.x == 0 ? VoxelIndex{} : low_; }
  VoxelIndex high() const { return high_; }

 private:
  VoxelIndex low_{.x = 1 << kDepth, .y = 1 << kDepth, .z = 1 << kDepth};
  VoxelIndex high_;
};

// Puts the leaves into a map whose lowest voxel has the key `low`.
class LeafPainter {
 public:
  LeafPainter(VoxelMap& map, VoxelIndex low) : map_(map), low_(low) {}
  void Visit(const Leaf& leaf) {
    const int width = 1 << leaf.level;
    const int z = leaf.z - low_.z;
    for (int y = leaf.y - low_.y; y < leaf.y - low_.y + width; ++y) {
      for (int x = leaf.x - low_.x; x < leaf.x - low_.x + width; ++x) {
        map_.SetRun(x, y, z, z + width,
                    leaf.occupied ? Voxel::kOccupied : Voxel::kFree);
      }
    }
  }

 private:
  VoxelMap& map_;
  VoxelIndex low_;
};

// Reads nodes in the file's order, depth first, and shows the leaves to a
// visitor. So a file is read twice, and its leaves need no memory.
template <typename Visitor>
class TreeReader {
 public:
  TreeReader(absl::string_view bytes, absl::string_view name, const Head& head,
             double occupied_threshold, Visitor& visitor)
      : bytes_(bytes),
        name_(name),
        head_(head),
        visitor_(visitor),
        occupied_log_odds_(static_cast<float>(
            std::log(occupied_threshold / (1 - occupied_threshold)))) {}

  absl::Status Read() {
    if (head_.nodes > 0) {
      TL_RETURN_IF_ERROR(head_.binary ? ReadBinary({}, kDepth)
                                      : ReadFull({}, kDepth));
    }
    if (nodes_ != head_.nodes) {
      return FileError(name_, absl::StrCat("its head says ", head_.nodes,
                                           " nodes, but there are ", nodes_));
    }
    if (at_ != bytes_.size()) {
      return FileError(name_, absl::StrCat(bytes_.size() - at_,
                                           " bytes follow the last node"));
    }
    return absl::OkStatus();
  }

 private:
  absl::Status Need(size_t bytes) const {
    if (bytes_.size() - at_ >= bytes) return absl::OkStatus();
    return FileError(
        name_, absl::StrCat("it ends in node ", nodes_, " of ", head_.nodes));
  }
  absl::Status TooDeep() const {
    return FileError(name_, "a node lies deeper than OctoMap's 16 levels");
  }
  static Leaf Child(const Leaf& parent, int child, int level) {
    const int half = 1 << level;
    return {.x = static_cast<uint16_t>(parent.x + (child & 1) * half),
            .y = static_cast<uint16_t>(parent.y + (child >> 1 & 1) * half),
            .z = static_cast<uint16_t>(parent.z + (child >> 2) * half),
            .level = static_cast<uint8_t>(level),
            .occupied = false};
  }

  // Two bits for each child: nothing, free, occupied, or a node of its own,
  // which follows. `node` spans 2^level voxels.
  absl::Status ReadBinary(const Leaf& node, int level) {
    ++nodes_;
    if (level == 0) return TooDeep();
    TL_RETURN_IF_ERROR(Need(2));
    const int bits = static_cast<uint8_t>(bytes_[at_]) |
                     static_cast<uint8_t>(bytes_[at_ + 1]) << 8;
    at_ += 2;
    for (int child = 0; child < 8; ++child) {
      const int kind = bits >> (2 * child) & 3;
      if (kind != 1 && kind != 2) continue;
      Leaf leaf = Child(node, child, level - 1);
      leaf.occupied = kind == 2;
      visitor_.Visit(leaf);
      ++nodes_;
    }
    for (int child = 0; child < 8; ++child) {
      if ((bits >> (2 * child) & 3) != 3) continue;
      TL_RETURN_IF_ERROR(ReadBinary(Child(node, child, level - 1), level - 1));
    }
    return absl::OkStatus();
  }

  // Log-odds, a colour, one bit for each child; the children follow.
  absl::Status ReadFull(Leaf node, int level) {
    ++nodes_;
    const size_t value_bytes = head_.colored ? 7 : 4;
    TL_RETURN_IF_ERROR(Need(value_bytes + 1));
    uint32_t value_bits = 0;
    for (size_t i = 0; i < 4; ++i) {
      value_bits |= uint32_t{static_cast<uint8_t>(bytes_[at_ + i])} << (8 * i);
    }
    const auto log_odds = std::bit_cast<float>(value_bits);
    const int children = static_cast<uint8_t>(bytes_[at_ + value_bytes]);
    at_ += value_bytes + 1;
    if (!std::isfinite(log_odds)) {
      return FileError(name_, absl::StrCat("the occupancy of node ", nodes_,
                                           " is not a number"));
    }
    if (children == 0) {
      node.level = static_cast<uint8_t>(level);
      node.occupied = log_odds >= occupied_log_odds_;
      visitor_.Visit(node);
      return absl::OkStatus();
    }
    if (level == 0) return TooDeep();
    for (int child = 0; child < 8; ++child) {
      if ((children >> child & 1) == 0) continue;
      TL_RETURN_IF_ERROR(ReadFull(Child(node, child, level - 1), level - 1));
    }
    return absl::OkStatus();
  }

  absl::string_view bytes_;
  absl::string_view name_;
  Head head_;
  Visitor& visitor_;
  float occupied_log_odds_;
  size_t at_ = 0;
  uint64_t nodes_ = 0;
};

// Writes nodes depth first, and takes back those of cubes that turn out to be
// all of one kind: the pruned tree.
class TreeWriter {
 public:
  TreeWriter(const VoxelMap& map, bool binary)
      : map_(map),
        binary_(binary),
        offset_{kCenter + map.lowest().x, kCenter + map.lowest().y,
                kCenter + map.lowest().z} {}

  // Of the whole tree.
  void Write() { WriteCube({}, kDepth); }
  const std::string& bytes() const { return bytes_; }
  uint64_t nodes() const { return nodes_; }

 private:
  // Mixed cubes come without and with occupied voxels.
  enum class Kind : uint8_t {
    kUnknown,
    kFree,
    kOccupied,
    kMixedFree,
    kMixedOccupied
  };

  bool IsOutside(VoxelIndex key, int level) const {
    const int width = 1 << level;
    const auto outside = [width](int from, int begin, int size) {
      return from + width <= begin || from >= begin + size;
    };
    return outside(key.x, offset_.x, map_.size().x) ||
           outside(key.y, offset_.y, map_.size().y) ||
           outside(key.z, offset_.z, map_.size().z);
  }

  Kind WriteLeaf(Kind kind) {
    if (kind == Kind::kUnknown) return kind;
    ++nodes_;
    if (!binary_) {
      PutLogOdds(bytes_.size(),
                 kind == Kind::kOccupied ? kOccupiedLogOdds : kFreeLogOdds);
      bytes_.push_back(0);
    }
    return kind;
  }

  Kind WriteCube(VoxelIndex key, int level) {
    if (IsOutside(key, level)) return Kind::kUnknown;
    if (level == 0) {
      const VoxelIndex v{key.x - offset_.x, key.y - offset_.y,
                         key.z - offset_.z};
      return WriteLeaf(static_cast<Kind>(map_.At(v)));
    }
    const size_t begin = bytes_.size();
    const uint64_t nodes_before = nodes_;
    ++nodes_;
    bytes_.append(binary_ ? 2 : 5, '\0');
    std::array<Kind, 8> kinds{};
    const int half = 1 << (level - 1);
    for (int child = 0; child < 8; ++child) {
      kinds[static_cast<size_t>(child)] = WriteCube(
          {key.x + (child & 1) * half, key.y + (child >> 1 & 1) * half,
           key.z + (child >> 2) * half},
          level - 1);
    }
    // The root stays, as OctoMap's does.
    const bool uniform =
        kinds[0] < Kind::kMixedFree &&
        std::all_of(kinds.begin(), kinds.end(),
                    [&kinds](Kind kind) { return kind == kinds[0]; });
    if (uniform && level < kDepth) {
      bytes_.resize(begin);
      nodes_ = nodes_before;
      return WriteLeaf(kinds[0]);
    }
    return FillNode(begin, kinds);
  }

  Kind FillNode(size_t begin, const std::array<Kind, 8>& kinds) {
    int bits = 0;
    bool occupied = false;
    for (size_t child = 0; child < 8; ++child) {
      const int kind = std::min(3, static_cast<int>(kinds[child]));
      bits |= binary_ ? kind << (2 * child) : (kind != 0 ? 1 : 0) << child;
      occupied = occupied || kinds[child] == Kind::kOccupied ||
                 kinds[child] == Kind::kMixedOccupied;
    }
    if (binary_) {
      bytes_[begin] = static_cast<char>(bits & 0xff);
      bytes_[begin + 1] = static_cast<char>(bits >> 8);
    } else {
      // An inner node is as occupied as its most occupied child.
      PutLogOdds(begin, occupied ? kOccupiedLogOdds : kFreeLogOdds);
      bytes_[begin + 4] = static_cast<char>(bits);
    }
    return occupied ? Kind::kMixedOccupied : Kind::kMixedFree;
  }

  void PutLogOdds(size_t at, float value) {
    if (bytes_.size() < at + 4) bytes_.resize(at + 4);
    const auto bits = std::bit_cast<uint32_t>(value);
    for (size_t i = 0; i < 4; ++i) {
      bytes_[at + i] = static_cast<char>(bits >> (8 * i) & 0xff);
    }
  }

  const VoxelMap& map_;
  bool binary_;
  VoxelIndex offset_;
  std::string bytes_;
  uint64_t nodes_ = 0;
};

absl::StatusOr<std::string> Format(const VoxelMap& map, bool binary) {
  const auto fits = [](int lowest, int size) {
    return lowest >= -kCenter && lowest + size <= kCenter;
  };
  if (!fits(map.lowest().x, map.size().x) ||
      !fits(map.lowest().y, map.size().y) ||
      !fits(map.lowest().z, map.size().z)) {
    return absl::InvalidArgumentError(
        "an OctoMap holds only the 2^15 voxels next to the origin each way");
  }
  std::string bytes;
  uint64_t nodes = 0;
  if (map.CountFree() + map.CountOccupied() > 0) {
    TreeWriter writer(map, binary);
    writer.Write();
    bytes = writer.bytes();
    nodes = writer.nodes();
  }
  return absl::StrCat(
      binary ? kBinaryHead : kFullHead,
      "\n# (feel free to add / change comments, but leave the first line as "
      "it is!)\n#\nid OcTree\nsize ",
      nodes, "\nres ", absl::StrFormat("%.9g", map.resolution_m()), "\ndata\n",
      bytes);
}

}  // namespace

absl::Status OctreeReadOptions::Validate() const {
  if (!(occupied_threshold > 0 && occupied_threshold < 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("occupied_threshold must be between 0 and 1; got ",
                     occupied_threshold));
  }
  if (max_bytes < 0) {
    return absl::InvalidArgumentError("max_bytes must not be negative");
  }
  return absl::OkStatus();
}

absl::StatusOr<VoxelMap> ParseOctree(absl::string_view bytes,
                                     absl::string_view name,
                                     const OctreeReadOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  absl::string_view rest = bytes;
  TL_ASSIGN_OR_RETURN(const Head head, TakeHead(rest, name));
  LeafBounds bounds;
  TL_RETURN_IF_ERROR(
      TreeReader(rest, name, head, options.occupied_threshold, bounds).Read());
  const VoxelIndex low = bounds.low();
  const VoxelIndex high = bounds.high();
  const VoxelIndex lowest =
      head.nodes == 0
          ? VoxelIndex{}
          : VoxelIndex{low.x - kCenter, low.y - kCenter, low.z - kCenter};
  absl::StatusOr<VoxelMap> map = VoxelMap::Make(
      head.resolution_m, lowest,
      {high.x - low.x, high.y - low.y, high.z - low.z}, options.max_bytes);
  if (!map.ok()) return base::Annotate(map.status(), name);
  LeafPainter painter(*map, low);
  TL_RETURN_IF_ERROR(
      TreeReader(rest, name, head, options.occupied_threshold, painter).Read());
  return map;
}

absl::StatusOr<VoxelMap> ReadOctree(const std::string& path,
                                    const OctreeReadOptions& options) {
  TL_ASSIGN_OR_RETURN(const std::string bytes, base::ReadFile(path));
  return ParseOctree(bytes, path, options);
}

absl::StatusOr<std::string> FormatBt(const VoxelMap& map) {
  return Format(map, /*binary=*/true);
}

absl::StatusOr<std::string> FormatOt(const VoxelMap& map) {
  return Format(map, /*binary=*/false);
}

absl::Status WriteOctree(const VoxelMap& map, const std::string& path) {
  const bool binary = absl::EndsWith(path, ".bt");
  if (!binary && !absl::EndsWith(path, ".ot")) {
    return absl::InvalidArgumentError(
        absl::StrCat("an OctoMap's name ends in .bt or .ot; got ", path));
  }
  TL_ASSIGN_OR_RETURN(const std::string bytes, Format(map, binary));
  return base::WriteFileAtomically(path, bytes);
}

}  // namespace treeline::octree

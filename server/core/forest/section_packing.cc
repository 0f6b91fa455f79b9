#include "server/core/forest/section_packing.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/core/forest/forest.h"
#include "server/core/forest/model_memory.h"

namespace treeline::forest {
namespace {

// Columns of a model are noise with a skewed histogram: more effort than this
// finds nothing more in them.
constexpr int kCompressionLevel = 3;
constexpr uint64_t kMaxExpansion = 32;
constexpr uint64_t kAlwaysAllowed_bytes = 1u << 20;
constexpr size_t kMaxRecordBytes = 256;
// Records whose columns are put together at a time, within the cache.
constexpr size_t kRecordsTogether = 128;

enum Layout : uint32_t { kRecords = 1, kNodes = 2 };

// Then a byte a field, width | 128 if it is a difference; then the columns,
// each a u64 of its length and its bytes.
struct PackedHeader {
  uint64_t unpacked_bytes;
  uint32_t layout;
  uint32_t fields;
};
static_assert(sizeof(PackedHeader) == 16);

absl::Status Corrupt(absl::string_view what) {
  return absl::DataLossError(absl::StrCat("corrupt packed section: ", what));
}

// Differences of either sign as small numbers.
uint32_t ZigZag(uint32_t difference) {
  return (difference << 1) ^ (0u - (difference >> 31));
}
uint32_t UnZigZag(uint32_t code) { return (code >> 1) ^ (0u - (code & 1)); }

uint32_t LoadField(const uint8_t* at, size_t width) {
  uint32_t value = 0;
  std::memcpy(&value, at, width);
  return value;
}

// A difference of 16-bit numbers, as of 32-bit ones.
uint32_t SignExtended(uint32_t difference, size_t width) {
  const size_t shift = 8 * (sizeof(uint32_t) - width);
  return static_cast<uint32_t>(static_cast<int32_t>(difference << shift) >>
                               shift);
}

class ColumnWriter {
 public:
  ColumnWriter(const PackedHeader& header, const RecordFields& fields) {
    packed_.assign(reinterpret_cast<const char*>(&header), sizeof(header));
    for (const PackedField& field : fields) {
      packed_.push_back(
          static_cast<char>(field.width | (field.is_delta ? 128 : 0)));
    }
  }

  void Add(const std::vector<uint8_t>& column) {
    buffer_.resize(ZSTD_compressBound(column.size()));
    size_t size = ZSTD_compress(buffer_.data(), buffer_.size(), column.data(),
                                column.size(), kCompressionLevel);
    const bool is_shorter = !ZSTD_isError(size) && size < column.size();
    if (!is_shorter) size = column.size();
    const uint64_t length = size;
    packed_.append(reinterpret_cast<const char*>(&length), sizeof(length));
    packed_.append(reinterpret_cast<const char*>(is_shorter ? buffer_.data()
                                                            : column.data()),
                   size);
  }

  std::string Take() { return std::move(packed_); }

 private:
  std::string packed_;
  std::vector<uint8_t> buffer_;
};

class ColumnReader {
 public:
  explicit ColumnReader(absl::string_view columns) : left_(columns) {}

  // The next column, of so many bytes.
  absl::Status Read(std::span<uint8_t> column) {
    uint64_t length = 0;
    if (left_.size() < sizeof(length)) return Corrupt("a column is missing");
    std::memcpy(&length, left_.data(), sizeof(length));
    left_.remove_prefix(sizeof(length));
    if (length > left_.size()) return Corrupt("a column lies outside");
    if (length > column.size()) return Corrupt("a column is too long");
    if (length == column.size()) {
      if (length > 0) std::memcpy(column.data(), left_.data(), length);
    } else if (ZSTD_decompress(column.data(), column.size(), left_.data(),
                               length) != column.size()) {
      return Corrupt("a column cannot be decompressed");
    }
    left_.remove_prefix(length);
    return absl::OkStatus();
  }

  absl::Status CheckEnd() const {
    return left_.empty() ? absl::OkStatus() : Corrupt("bytes behind its end");
  }

 private:
  absl::string_view left_;
};

size_t RecordBytes(const RecordFields& fields) {
  size_t bytes = 0;
  for (const PackedField& field : fields) bytes += field.width;
  return bytes;
}

std::string Shorter(std::string packed, absl::string_view section) {
  const bool pays =
      packed.size() < section.size() && UnpackedBytes(packed).ok();
  return pays ? std::move(packed) : std::string();
}

// The nodes of a forest as columns.
struct NodeColumns {
  std::vector<uint8_t> is_leaf;  // a bit a node
  // A byte a split: the lower parts of dx and dy, their upper parts with the
  // channels, and the threshold.
  std::vector<uint8_t> dx;
  std::vector<uint8_t> dy;
  std::vector<uint8_t> rest;
  std::vector<uint8_t> threshold_low;
  std::vector<uint8_t> threshold_high;
  std::vector<uint8_t> modes;  // a byte a leaf, less 1

  std::array<std::vector<uint8_t>*, 7> All() {
    return {&is_leaf, &dx, &dy, &rest, &threshold_low, &threshold_high, &modes};
  }
};

// dx and dy are shifted by half their range, so that small ones are alike.
constexpr uint32_t kHalfRange = 512;

void AddSplit(const Node& node, NodeColumns& columns) {
  const uint32_t dx = ((node.lo & 1023u) + kHalfRange) & 1023u;
  const uint32_t dy = ((node.lo >> 10 & 1023u) + kHalfRange) & 1023u;
  columns.dx.push_back(static_cast<uint8_t>(dx));
  columns.dy.push_back(static_cast<uint8_t>(dy));
  columns.rest.push_back(static_cast<uint8_t>(dx >> 8 | (dy >> 8) << 2 |
                                              (node.lo >> 20 & 15u) << 4));
  const uint32_t threshold = ZigZag(static_cast<uint32_t>(node.threshold()));
  columns.threshold_low.push_back(static_cast<uint8_t>(threshold));
  columns.threshold_high.push_back(static_cast<uint8_t>(threshold >> 8));
}

// False: not the only way in which nodes of this order can be linked.
bool AddNode(size_t i, const Node& node, std::vector<size_t>& open,
             uint32_t& next_mode, std::vector<uint32_t>& right_offsets,
             NodeColumns& columns) {
  if (!node.is_leaf()) {
    if (node.lo >> 24 != 0) return false;
    right_offsets[i] = node.right_offset();
    open.push_back(i);
    AddSplit(node, columns);
    return true;
  }
  if (node.hi != 0 || node.leaf() != next_mode) return false;
  next_mode += node.modes();
  columns.is_leaf[i / 8] |= static_cast<uint8_t>(1u << (i % 8));
  columns.modes.push_back(static_cast<uint8_t>(node.modes() - 1));
  if (open.empty()) return true;
  const size_t parent = open.back();
  open.pop_back();
  return right_offsets[parent] == i + 1 - parent;
}

std::optional<NodeColumns> ColumnsOf(std::span<const Node> nodes) {
  NodeColumns columns;
  columns.is_leaf.resize((nodes.size() + 7) / 8);
  std::vector<size_t> open;  // splits whose right child comes later
  std::vector<uint32_t> right_offsets(nodes.size());
  uint32_t next_mode = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!AddNode(i, nodes[i], open, next_mode, right_offsets, columns)) {
      return std::nullopt;
    }
  }
  if (!open.empty()) return std::nullopt;
  return columns;
}

Node SplitOf(const NodeColumns& columns, size_t s) {
  const uint32_t rest = columns.rest[s];
  const uint32_t dx = ((columns.dx[s] | (rest & 3u) << 8) + kHalfRange) & 1023u;
  const uint32_t dy =
      ((columns.dy[s] | (rest >> 2 & 3u) << 8) + kHalfRange) & 1023u;
  const uint32_t threshold =
      UnZigZag(columns.threshold_low[s] |
               static_cast<uint32_t>(columns.threshold_high[s]) << 8);
  // Its right child is not known yet.
  return {dx | dy << 10 | (rest >> 4) << 20, (threshold + 256u) & 511u};
}

absl::Status UnpackNodes(ColumnReader reader, std::span<Node> nodes) {
  NodeColumns columns;
  columns.is_leaf.resize((nodes.size() + 7) / 8);
  TL_RETURN_IF_ERROR(reader.Read(columns.is_leaf));
  const auto is_leaf = [&](size_t i) {
    return (columns.is_leaf[i / 8] >> (i % 8) & 1u) != 0;
  };
  size_t leaves = 0;
  for (size_t i = 0; i < nodes.size(); ++i) leaves += is_leaf(i) ? 1 : 0;
  for (std::vector<uint8_t>* column : columns.All()) {
    if (column == &columns.is_leaf) continue;
    column->resize(column == &columns.modes ? leaves : nodes.size() - leaves);
    TL_RETURN_IF_ERROR(reader.Read(*column));
  }
  TL_RETURN_IF_ERROR(reader.CheckEnd());
  std::vector<size_t> open;
  uint64_t next_mode = 0;
  size_t split = 0;
  size_t leaf = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!is_leaf(i)) {
      nodes[i] = SplitOf(columns, split++);
      open.push_back(i);
      continue;
    }
    const uint32_t modes = columns.modes[leaf++] + 1u;
    if (modes > Node::kMaxModes || next_mode >> Node::kModeBits != 0) {
      return Corrupt("too many modes");
    }
    nodes[i] = Node::Leaf(static_cast<uint32_t>(next_mode), modes);
    next_mode += modes;
    if (open.empty()) continue;  // a tree ends here
    const size_t parent = open.back();
    open.pop_back();
    const size_t offset = i + 1 - parent;
    if (offset > Node::kMaxNodesPerTree) return Corrupt("too many nodes");
    nodes[parent].hi |= static_cast<uint32_t>(offset) << 9;
  }
  return open.empty() ? absl::OkStatus() : Corrupt("a tree without its end");
}

// Undoes differences within a field's columns, `count` bytes each.
void Accumulate(std::span<uint8_t> columns, size_t count, size_t width) {
  uint32_t value = 0;
  for (size_t i = 0; i < count; ++i) {
    uint32_t code = 0;
    for (size_t b = 0; b < width; ++b) {
      code |= static_cast<uint32_t>(columns[b * count + i]) << (8 * b);
    }
    value += UnZigZag(code);
    for (size_t b = 0; b < width; ++b) {
      columns[b * count + i] = static_cast<uint8_t>(value >> (8 * b));
    }
  }
}

absl::Status UnpackRecords(ColumnReader reader, const RecordFields& fields,
                           std::span<uint8_t> out) {
  const size_t stride = RecordBytes(fields);
  const size_t count = out.size() / stride;
  TL_ASSIGN_OR_RETURN(ModelMemory memory, ModelMemory::Allocate(out.size()));
  const std::span<uint8_t> columns = memory.writable();
  size_t column = 0;
  for (const PackedField& field : fields) {
    const std::span<uint8_t> of_field =
        columns.subspan(column * count, field.width * count);
    for (size_t b = 0; b < field.width; ++b) {
      TL_RETURN_IF_ERROR(reader.Read(of_field.subspan(b * count, count)));
    }
    if (field.is_delta) Accumulate(of_field, count, field.width);
    column += field.width;
  }
  TL_RETURN_IF_ERROR(reader.CheckEnd());
  for (size_t begin = 0; begin < count; begin += kRecordsTogether) {
    const size_t end = std::min(begin + kRecordsTogether, count);
    for (size_t c = 0; c < stride; ++c) {
      const uint8_t* from = columns.data() + c * count;
      uint8_t* to = out.data() + c;
      for (size_t i = begin; i < end; ++i) to[i * stride] = from[i];
    }
  }
  return absl::OkStatus();
}

}  // namespace

RecordFields FieldsAlike(size_t count, PackedField field) {
  return RecordFields(count, field);
}

std::string PackRecords(absl::string_view section, const RecordFields& fields) {
  const size_t stride = RecordBytes(fields);
  if (stride == 0 || stride > kMaxRecordBytes || section.size() % stride != 0) {
    return "";
  }
  const size_t count = section.size() / stride;
  ColumnWriter writer(
      {section.size(), kRecords, static_cast<uint32_t>(fields.size())}, fields);
  const auto* bytes = reinterpret_cast<const uint8_t*>(section.data());
  std::vector<uint32_t> values(count);
  std::vector<uint8_t> column(count);
  size_t offset = 0;
  for (const PackedField& field : fields) {
    uint32_t before = 0;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t value =
          LoadField(bytes + i * stride + offset, field.width);
      values[i] = field.is_delta
                      ? ZigZag(SignExtended(value - before, field.width))
                      : value;
      before = value;
    }
    for (size_t b = 0; b < field.width; ++b) {
      for (size_t i = 0; i < count; ++i) {
        column[i] = static_cast<uint8_t>(values[i] >> (8 * b));
      }
      writer.Add(column);
    }
    offset += field.width;
  }
  return Shorter(writer.Take(), section);
}

std::string PackNodes(absl::string_view section) {
  const std::span<const Node> nodes(
      reinterpret_cast<const Node*>(section.data()),
      section.size() / sizeof(Node));
  std::optional<NodeColumns> columns = ColumnsOf(nodes);
  if (!columns) return PackRecords(section, FieldsAlike(sizeof(Node), {}));
  ColumnWriter writer({section.size(), kNodes, 0}, {});
  for (const std::vector<uint8_t>* column : columns->All()) {
    writer.Add(*column);
  }
  return Shorter(writer.Take(), section);
}

absl::StatusOr<uint64_t> UnpackedBytes(absl::string_view packed) {
  PackedHeader header;
  if (packed.size() < sizeof(header)) return Corrupt("shorter than its header");
  std::memcpy(&header, packed.data(), sizeof(header));
  if (header.unpacked_bytes > kAlwaysAllowed_bytes &&
      header.unpacked_bytes / kMaxExpansion > packed.size()) {
    return Corrupt(absl::StrCat("it says that its ", packed.size(),
                                " bytes become ", header.unpacked_bytes));
  }
  return header.unpacked_bytes;
}

absl::Status UnpackSection(absl::string_view packed, std::span<uint8_t> out) {
  TL_ASSIGN_OR_RETURN(const uint64_t bytes, UnpackedBytes(packed));
  if (bytes != out.size()) return Corrupt("another length than it says");
  PackedHeader header;
  std::memcpy(&header, packed.data(), sizeof(header));
  packed.remove_prefix(sizeof(header));
  if (header.layout == kNodes && header.fields == 0) {
    if (out.size() % sizeof(Node) != 0) return Corrupt("half a node");
    return UnpackNodes(
        ColumnReader(packed),
        {reinterpret_cast<Node*>(out.data()), out.size() / sizeof(Node)});
  }
  if (header.layout != kRecords || header.fields > kMaxRecordBytes ||
      header.fields > packed.size()) {
    return Corrupt("no such layout");
  }
  RecordFields fields;
  for (const char code : packed.substr(0, header.fields)) {
    const uint8_t width = static_cast<uint8_t>(code) & 127u;
    if (width != 1 && width != 2 && width != 4) return Corrupt("a field");
    fields.push_back({width, (static_cast<uint8_t>(code) & 128u) != 0});
  }
  const size_t stride = RecordBytes(fields);
  if (stride == 0 || stride > kMaxRecordBytes || out.size() % stride != 0) {
    return Corrupt("a bad record");
  }
  return UnpackRecords(ColumnReader(packed.substr(header.fields)), fields, out);
}

}  // namespace treeline::forest

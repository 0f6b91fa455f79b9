#include "server/core/forest/model_file.h"

#include <xxhash.h>

#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_info_json.h"

namespace treeline {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is little-endian and read in place");

constexpr char kMagic[8] = {'T', 'R', 'E', 'E', 'L', 'I', 'N', 'E'};
constexpr uint64_t kAlignment = 64;

struct Header {
  char magic[8];
  uint32_t version;
  uint32_t sections;
  uint64_t file_bytes;
  uint64_t checksum;  // see Checksum
  uint8_t reserved[32];
};
static_assert(sizeof(Header) == 64);

enum SectionKind : uint32_t {
  kInfo = 1,
  kBounds = 2,
  kTreeOffsets = 3,
  kNodes = 4,
  kDescriptors = 5,
  kPayloads = 6,
};
constexpr uint32_t kSections = 6;

struct Section {
  uint32_t kind;
  uint32_t reserved;
  uint64_t offset;
  uint64_t bytes;
};
static_assert(sizeof(Section) == 24);

struct Bounds {
  double min[3];
  double max[3];
};

uint64_t Align(uint64_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

template <typename T>
absl::string_view Bytes(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

// XXH3-64 of all bytes behind the header, seeded with the XXH3-64 of the header
// in which the checksum is zero: covers every byte of the file.
uint64_t Checksum(Header header, absl::string_view behind_header) {
  header.checksum = 0;
  return XXH3_64bits_withSeed(behind_header.data(), behind_header.size(),
                              XXH3_64bits(&header, sizeof(header)));
}

absl::Status Corrupt(absl::string_view what) {
  return absl::DataLossError(absl::StrCat("corrupt model: ", what));
}

// The section's bytes as values of type T. Offsets are aligned to 64 bytes and
// the mapping to a page, so the values are aligned too.
template <typename T>
absl::Status ReadSection(const MappedFile& file,
                         std::span<const Section> sections, SectionKind kind,
                         std::span<const T>& out) {
  for (const Section& section : sections) {
    if (section.kind != kind) continue;
    if (section.offset % kAlignment != 0 || section.offset > file.size() ||
        section.bytes > file.size() - section.offset ||
        section.bytes % sizeof(T) != 0) {
      return Corrupt(absl::StrCat("section ", kind, " lies outside the file"));
    }
    out = {reinterpret_cast<const T*>(file.data() + section.offset),
           section.bytes / sizeof(T)};
    return absl::OkStatus();
  }
  return Corrupt(absl::StrCat("section ", kind, " is missing"));
}

}  // namespace

absl::Status WriteModel(const std::string& path, const ModelInfo& info,
                        const ForestView& forest) {
  TL_RETURN_IF_ERROR(forest.Validate());
  TL_RETURN_IF_ERROR(CheckWritable(path));
  const std::string info_json = ModelInfoToJson(info);
  const Vec3& low = forest.bounds_min_in_world;
  const Vec3& high = forest.bounds_max_in_world;
  const Bounds bounds = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
  const absl::string_view contents[kSections] = {
      info_json,
      Bytes(std::span<const Bounds>(&bounds, 1)),
      Bytes(forest.tree_offsets),
      Bytes(forest.nodes),
      Bytes(forest.descriptors),
      Bytes(forest.payloads)};
  Section table[kSections];
  uint64_t end = sizeof(Header) + sizeof(table);
  for (uint32_t i = 0; i < kSections; ++i) {
    table[i] = {kInfo + i, 0, Align(end), contents[i].size()};
    end = table[i].offset + table[i].bytes;
  }
  std::string file(end, '\0');
  std::memcpy(file.data() + sizeof(Header), table, sizeof(table));
  for (uint32_t i = 0; i < kSections; ++i) {
    std::memcpy(file.data() + table[i].offset, contents[i].data(),
                contents[i].size());
  }
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.version = kModelFormatVersion;
  header.sections = kSections;
  header.file_bytes = end;
  header.checksum =
      Checksum(header, absl::string_view(file).substr(sizeof(Header)));
  std::memcpy(file.data(), &header, sizeof(header));
  return WriteFileAtomically(path, file);
}

absl::StatusOr<std::unique_ptr<const ModelFile>> ModelFile::Open(
    const std::string& path) {
  std::unique_ptr<ModelFile> model(new ModelFile);
  TL_ASSIGN_OR_RETURN(model->file_, MappedFile::Open(path));
  if (absl::Status status = model->Parse(); !status.ok()) {
    return Annotate(status, path);
  }
  return std::unique_ptr<const ModelFile>(std::move(model));
}

absl::Status ModelFile::Parse() {
  Header header;
  if (file_.size() < sizeof(header)) {
    return Corrupt("shorter than a header; was it copied whole?");
  }
  std::memcpy(&header, file_.data(), sizeof(header));
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) {
    return absl::DataLossError("not a Treeline model file");
  }
  if (header.version > kModelFormatVersion) {
    return absl::UnimplementedError(absl::StrCat(
        "model format ", header.version, " is newer than this software, which ",
        "reads up to ", kModelFormatVersion, "; update it"));
  }
  if (header.version == 0) return Corrupt("format version 0");
  if (header.file_bytes != file_.size()) {
    return Corrupt(absl::StrCat("it should have ", header.file_bytes,
                                " bytes and has ", file_.size(),
                                "; was it copied whole?"));
  }
  const uint64_t checksum = Checksum(
      header, {reinterpret_cast<const char*>(file_.data()) + sizeof(header),
               file_.size() - sizeof(header)});
  if (checksum != header.checksum) return Corrupt("checksum mismatch");
  if (header.sections > 64 ||
      sizeof(header) + header.sections * sizeof(Section) > file_.size()) {
    return Corrupt("bad section table");
  }
  const std::span<const Section> sections(
      reinterpret_cast<const Section*>(file_.data() + sizeof(header)),
      header.sections);

  std::span<const char> info_json;
  TL_RETURN_IF_ERROR(ReadSection(file_, sections, kInfo, info_json));
  TL_ASSIGN_OR_RETURN(info_,
                      ModelInfoFromJson({info_json.data(), info_json.size()}));
  std::span<const Bounds> bounds;
  TL_RETURN_IF_ERROR(ReadSection(file_, sections, kBounds, bounds));
  if (bounds.size() != 1) return Corrupt("bad bounds");
  const Bounds& b = bounds[0];
  forest_.bounds_min_in_world = {b.min[0], b.min[1], b.min[2]};
  forest_.bounds_max_in_world = {b.max[0], b.max[1], b.max[2]};
  TL_RETURN_IF_ERROR(
      ReadSection(file_, sections, kTreeOffsets, forest_.tree_offsets));
  TL_RETURN_IF_ERROR(ReadSection(file_, sections, kNodes, forest_.nodes));
  TL_RETURN_IF_ERROR(
      ReadSection(file_, sections, kDescriptors, forest_.descriptors));
  TL_RETURN_IF_ERROR(ReadSection(file_, sections, kPayloads, forest_.payloads));
  TL_RETURN_IF_ERROR(forest_.Validate());

  info_.format_version = header.version;
  info_.bounds_min_in_world = forest_.bounds_min_in_world;
  info_.bounds_max_in_world = forest_.bounds_max_in_world;
  info_.trees = forest_.trees();
  info_.nodes = static_cast<int64_t>(forest_.nodes.size());
  info_.leaves = static_cast<int64_t>(forest_.payloads.size());
  info_.file_bytes = file_.size();
  info_.checksum = absl::StrFormat("%016x", checksum);
  return absl::OkStatus();
}

}  // namespace treeline

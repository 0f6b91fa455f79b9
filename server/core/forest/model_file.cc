#include "server/core/forest/model_file.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/input_file.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_info_json.h"
#include "server/core/forest/section_packing.h"

namespace treeline::forest {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is little-endian and used as it is in memory");

constexpr char kMagic[8] = {'T', 'R', 'E', 'E', 'L', 'I', 'N', 'E'};
constexpr uint64_t kAlignment = 64;
// Read and hashed at a time: what was read is still in the processor's cache
// when it is hashed.
constexpr uint64_t kReadStep_bytes = 256u << 10;

struct Header {
  char magic[8];
  uint32_t version;
  uint32_t sections;
  uint64_t file_bytes;
  uint64_t checksum;  // see ChecksumSeed
  // From version 2 on: of the header, the table and all sections, unpacked and
  // in the table's order, each aligned: what a reader needs.
  uint64_t memory_bytes;
  uint8_t reserved[24];
};
static_assert(sizeof(Header) == 64);

// 8 and more are of ModelExtra.
enum SectionKind : uint32_t {
  kInfo = 1,
  kBounds = 2,
  kTreeOffsets = 3,
  kNodes = 4,
  kDescriptors = 5,
  kPayloads = 6,
  kSiftDescriptors = 7,
};
constexpr uint32_t kFirstExtra = 8;
// Of a section's kind: it is packed (section_packing.h).
constexpr uint32_t kPacked = 0x80000000u;
constexpr uint32_t kMaxForests = 8;

struct Section {
  uint32_t kind;
  uint32_t forest;  // which one it is of; 0 if of none
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

// The checksum is the XXH3-64 of all bytes behind the header with this seed,
// the XXH3-64 of the header in which the checksum is zero: so it covers every
// byte of the file.
uint64_t ChecksumSeed(Header header) {
  header.checksum = 0;
  return XXH3_64bits(&header, sizeof(header));
}

uint64_t MemoryBytes(const Header& header) {
  return header.version == 1 ? header.file_bytes : header.memory_bytes;
}

absl::Status Corrupt(absl::string_view what) {
  return absl::DataLossError(absl::StrCat("corrupt model: ", what));
}

constexpr PackedField kByte{};
constexpr PackedField kDelta16{.width = 2, .is_delta = true};
constexpr PackedField kDelta32{.width = 4, .is_delta = true};

RecordFields ThenBytes(RecordFields fields, size_t bytes) {
  fields.resize(fields.size() + bytes, kByte);
  return fields;
}

// How each kind of section is packed; none: it never is.
RecordFields FieldsOf(uint32_t kind) {
  switch (kind) {
    case kDescriptors:
      return FieldsAlike(64, kByte);
    case kPayloads:
      return ThenBytes(FieldsAlike(3, kDelta16), 14);
    case kSiftDescriptors:
    case static_cast<uint32_t>(ModelExtra::kKeyframeWords):
      return FieldsAlike(128, kByte);
    case static_cast<uint32_t>(ModelExtra::kKeyframes):
      return FieldsAlike(64, kByte);
    case static_cast<uint32_t>(ModelExtra::kKeyframePoints):
      return ThenBytes(FieldsAlike(3, kDelta32), 8);
    case static_cast<uint32_t>(ModelExtra::kKeyframeFeatures): {
      RecordFields fields = FieldsAlike(12, kByte);
      fields.push_back(kDelta32);
      return ThenBytes(std::move(fields), 128);
    }
    case static_cast<uint32_t>(ModelExtra::kSceneDescriptor):
      return {kByte};
    case static_cast<uint32_t>(ModelExtra::kKeyframeFeatureWords):
      return FieldsAlike(2, kByte);
    default:
      return {};
  }
}

// Empty: it stays as it is.
std::string Pack(uint32_t kind, absl::string_view section) {
  return kind == kNodes ? PackNodes(section)
                        : PackRecords(section, FieldsOf(kind));
}

// Null if there is none.
const Section* FindSection(std::span<const Section> sections, uint32_t kind,
                           uint32_t forest) {
  const auto found =
      std::ranges::find_if(sections, [&](const Section& section) {
        return (section.kind & ~kPacked) == kind && section.forest == forest;
      });
  return found == sections.end() ? nullptr : &*found;
}

// That it lies in a file of that length, where values can be aligned.
absl::Status CheckPlace(const Section& section, uint64_t file_bytes) {
  if (section.offset % kAlignment == 0 && section.offset <= file_bytes &&
      section.bytes <= file_bytes - section.offset) {
    return absl::OkStatus();
  }
  return Corrupt(
      absl::StrCat("section ", section.kind, " lies outside the file"));
}

// The sections of a file in memory.
class SectionReader {
 public:
  SectionReader(std::span<const uint8_t> file,
                std::span<const Section> sections)
      : file_(file), sections_(sections) {}

  bool Has(uint32_t kind, uint32_t forest) const {
    return FindSection(sections_, kind, forest) != nullptr;
  }

  // The section's bytes as values of type T. Offsets are aligned to 64 bytes
  // and the memory to a page, so the values are aligned too.
  template <typename T>
  absl::Status Read(uint32_t kind, uint32_t forest,
                    std::span<const T>& out) const {
    const Section* section = FindSection(sections_, kind, forest);
    if (section == nullptr) {
      return Corrupt(absl::StrCat("section ", kind, " is missing"));
    }
    TL_RETURN_IF_ERROR(CheckPlace(*section, file_.size()));
    if (section->bytes % sizeof(T) != 0) {
      return Corrupt(absl::StrCat("section ", kind, " has an odd length"));
    }
    out = {reinterpret_cast<const T*>(file_.data() + section->offset),
           section->bytes / sizeof(T)};
    return absl::OkStatus();
  }

 private:
  const std::span<const uint8_t> file_;
  const std::span<const Section> sections_;
};

absl::Status ReadForest(const SectionReader& reader, uint32_t f,
                        ForestView& forest) {
  std::span<const Bounds> bounds;
  TL_RETURN_IF_ERROR(reader.Read(kBounds, f, bounds));
  if (bounds.size() != 1) return Corrupt("bad bounds");
  const Bounds& b = bounds[0];
  forest.bounds_min_in_world = {b.min[0], b.min[1], b.min[2]};
  forest.bounds_max_in_world = {b.max[0], b.max[1], b.max[2]};
  TL_RETURN_IF_ERROR(reader.Read(kTreeOffsets, f, forest.tree_offsets));
  TL_RETURN_IF_ERROR(reader.Read(kNodes, f, forest.nodes));
  if (reader.Has(kSiftDescriptors, f)) {
    TL_RETURN_IF_ERROR(
        reader.Read(kSiftDescriptors, f, forest.sift_descriptors));
  } else {
    TL_RETURN_IF_ERROR(reader.Read(kDescriptors, f, forest.descriptors));
  }
  TL_RETURN_IF_ERROR(reader.Read(kPayloads, f, forest.payloads));
  return forest.Validate();
}

template <typename T>
std::span<uint8_t> WritableBytes(std::span<T> values) {
  return {reinterpret_cast<uint8_t*>(values.data()), values.size_bytes()};
}

// Magic, version, length, and that the section table lies inside the file.
absl::StatusOr<Header> ReadHeader(const base::InputFile& file) {
  Header header;
  if (file.size() < sizeof(header)) {
    return Corrupt("shorter than a header; was it copied whole?");
  }
  TL_RETURN_IF_ERROR(
      file.ReadAt(0, WritableBytes(std::span<Header>(&header, 1))));
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) {
    return absl::DataLossError("not a Treeline model file");
  }
  if (header.version > kModelFormatVersion) {
    return absl::UnimplementedError(absl::StrCat(
        "model format ", header.version, " is newer than this software, which ",
        "reads up to ", kModelFormatVersion, "; update it"));
  }
  if (header.version == 0) return Corrupt("format version 0");
  if (header.file_bytes != file.size()) {
    return Corrupt(absl::StrCat("it should have ", header.file_bytes,
                                " bytes and has ", file.size(),
                                "; was it copied whole?"));
  }
  if (header.sections > 64 ||
      sizeof(header) + header.sections * sizeof(Section) > file.size()) {
    return Corrupt("bad section table");
  }
  if (MemoryBytes(header) > kMaxModelMemory_bytes) {
    return Corrupt(absl::StrCat("it would take ", MemoryBytes(header),
                                " bytes in memory"));
  }
  return header;
}

// The section as the file has it.
absl::string_view BytesAt(std::span<const uint8_t> file,
                          const Section& section) {
  return {reinterpret_cast<const char*>(file.data()) + section.offset,
          section.bytes};
}

// Where sections lie when all are unpacked, and what that takes.
struct UnpackedPlaces {
  std::vector<Section> sections;
  uint64_t memory_bytes = 0;
};

absl::StatusOr<UnpackedPlaces> PlacesInMemory(
    std::span<const uint8_t> file, std::span<const Section> sections) {
  UnpackedPlaces places;
  places.memory_bytes = sizeof(Header) + sections.size_bytes();
  for (const Section& section : sections) {
    TL_RETURN_IF_ERROR(CheckPlace(section, file.size()));
    uint64_t bytes = section.bytes;
    if ((section.kind & kPacked) != 0) {
      TL_ASSIGN_OR_RETURN(bytes, UnpackedBytes(BytesAt(file, section)));
    }
    const uint64_t offset = Align(places.memory_bytes);
    if (bytes > kMaxModelMemory_bytes ||
        offset + bytes > kMaxModelMemory_bytes) {
      return Corrupt("its sections would take too much memory");
    }
    places.sections.push_back(
        {section.kind & ~kPacked, section.forest, offset, bytes});
    places.memory_bytes = offset + bytes;
  }
  return places;
}

// The file as it were without packed sections.
absl::StatusOr<ModelMemory> Unpack(std::span<const uint8_t> file,
                                   std::span<const Section> sections,
                                   const UnpackedPlaces& places) {
  TL_ASSIGN_OR_RETURN(ModelMemory memory,
                      ModelMemory::Allocate(places.memory_bytes));
  const std::span<uint8_t> out = memory.writable();
  std::memcpy(out.data(), file.data(), sizeof(Header));
  // There may be none, and then nothing to point at.
  std::ranges::copy(Bytes(std::span<const Section>(places.sections)),
                    reinterpret_cast<char*>(out.data()) + sizeof(Header));
  for (size_t i = 0; i < sections.size(); ++i) {
    const absl::string_view bytes = BytesAt(file, sections[i]);
    const Section& place = places.sections[i];
    if ((sections[i].kind & kPacked) != 0) {
      TL_RETURN_IF_ERROR(
          UnpackSection(bytes, out.subspan(place.offset, place.bytes)));
    } else if (!bytes.empty()) {
      std::memcpy(out.data() + place.offset, bytes.data(), bytes.size());
    }
  }
  memory.Seal();
  return memory;
}

// All bytes of the file behind `header`, which was read from it, at their
// places; their checksum is that of the header.
absl::StatusOr<ModelMemory> ReadVerified(const base::InputFile& file,
                                         const Header& header) {
  TL_ASSIGN_OR_RETURN(ModelMemory memory, ModelMemory::Allocate(file.size()));
  const std::span<uint8_t> bytes = memory.writable();
  std::memcpy(bytes.data(), &header, sizeof(header));
  file.Prefetch();
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash(
      XXH3_createState(), &XXH3_freeState);
  if (hash == nullptr) return absl::ResourceExhaustedError("no memory");
  XXH3_64bits_reset_withSeed(hash.get(), ChecksumSeed(header));
  for (uint64_t at = sizeof(header); at < bytes.size();) {
    const std::span<uint8_t> step =
        bytes.subspan(at, std::min(kReadStep_bytes, bytes.size() - at));
    TL_RETURN_IF_ERROR(file.ReadAt(at, step));
    XXH3_64bits_update(hash.get(), step.data(), step.size());
    at += step.size();
  }
  if (XXH3_64bits_digest(hash.get()) != header.checksum) {
    return Corrupt("checksum mismatch");
  }
  memory.Seal();
  return memory;
}

// The file of sections with these contents, packed where that is shorter.
std::string Assemble(std::vector<Section> table,
                     std::vector<absl::string_view> contents) {
  uint64_t end = sizeof(Header) + table.size() * sizeof(Section);
  uint64_t memory_end = end;
  std::vector<std::string> packed(table.size());
  for (size_t i = 0; i < table.size(); ++i) {
    memory_end = Align(memory_end) + contents[i].size();
    packed[i] = Pack(table[i].kind, contents[i]);
    if (!packed[i].empty()) {
      table[i].kind |= kPacked;
      contents[i] = packed[i];
    }
    table[i].offset = Align(end);
    table[i].bytes = contents[i].size();
    end = table[i].offset + table[i].bytes;
  }
  std::string file(end, '\0');
  std::memcpy(file.data() + sizeof(Header), table.data(),
              table.size() * sizeof(Section));
  for (size_t i = 0; i < table.size(); ++i) {
    if (contents[i].empty()) continue;  // of which there may be no address
    std::memcpy(file.data() + table[i].offset, contents[i].data(),
                contents[i].size());
  }
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.version = kModelFormatVersion;
  header.sections = static_cast<uint32_t>(table.size());
  header.file_bytes = end;
  header.memory_bytes = memory_end;
  header.checksum =
      XXH3_64bits_withSeed(file.data() + sizeof(header),
                           file.size() - sizeof(header), ChecksumSeed(header));
  std::memcpy(file.data(), &header, sizeof(header));
  return file;
}

geometry::Vec3 Least(geometry::Vec3 a, geometry::Vec3 b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}

}  // namespace

absl::StatusOr<std::string> EncodeModel(
    const ModelInfo& info, const std::vector<ForestView>& forests,
    std::span<const ModelExtraBytes> extras) {
  if (forests.empty() || forests.size() > kMaxForests) {
    return absl::InvalidArgumentError("a model has 1 to 8 forests");
  }
  const std::string info_json = ModelInfoToJson(info);
  std::vector<Bounds> bounds;
  std::vector<Section> table{{kInfo, 0, 0, 0}};
  std::vector<absl::string_view> contents{info_json};
  const auto add = [&](uint32_t kind, size_t forest, absl::string_view bytes) {
    table.push_back({kind, static_cast<uint32_t>(forest), 0, 0});
    contents.push_back(bytes);
  };
  bounds.reserve(forests.size());  // their addresses are kept
  for (size_t f = 0; f < forests.size(); ++f) {
    const ForestView& forest = forests[f];
    TL_RETURN_IF_ERROR(forest.Validate());
    const geometry::Vec3& low = forest.bounds_min_in_world;
    const geometry::Vec3& high = forest.bounds_max_in_world;
    bounds.push_back({{low.x, low.y, low.z}, {high.x, high.y, high.z}});
    add(kBounds, f, Bytes(std::span<const Bounds>(&bounds.back(), 1)));
    add(kTreeOffsets, f, Bytes(forest.tree_offsets));
    add(kNodes, f, Bytes(forest.nodes));
    if (forest.sift_descriptors.empty()) {
      add(kDescriptors, f, Bytes(forest.descriptors));
    } else {
      add(kSiftDescriptors, f, Bytes(forest.sift_descriptors));
    }
    add(kPayloads, f, Bytes(forest.payloads));
  }
  for (const ModelExtraBytes& extra : extras) {
    add(static_cast<uint32_t>(extra.kind), 0, extra.bytes);
  }
  return Assemble(std::move(table), std::move(contents));
}

absl::Status WriteModel(const std::string& path, const ModelInfo& info,
                        const std::vector<ForestView>& forests,
                        std::span<const ModelExtraBytes> extras) {
  TL_RETURN_IF_ERROR(base::CheckWritable(path));
  TL_ASSIGN_OR_RETURN(const std::string file,
                      EncodeModel(info, forests, extras));
  return base::WriteFileAtomically(path, file);
}
absl::StatusOr<std::unique_ptr<const ModelFile>> ModelFile::Open(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(const base::InputFile file, base::InputFile::Open(path));
  std::unique_ptr<ModelFile> model(new ModelFile);
  if (absl::Status status = model->Read(file); !status.ok()) {
    return base::Annotate(status, path);
  }
  return std::unique_ptr<const ModelFile>(std::move(model));
}

absl::Status ModelFile::Read(const base::InputFile& file) {
  TL_ASSIGN_OR_RETURN(const Header header, ReadHeader(file));
  TL_ASSIGN_OR_RETURN(memory_, ReadVerified(file, header));
  const auto table = [&] {
    return std::span<const Section>(
        reinterpret_cast<const Section*>(memory_.bytes().data() +
                                         sizeof(header)),
        header.sections);
  };
  for (const Section& section : table()) {
    sizes_.push_back({section.kind & ~kPacked, section.forest, section.bytes,
                      section.bytes});
  }
  if (header.version > 1) {
    TL_ASSIGN_OR_RETURN(const UnpackedPlaces places,
                        PlacesInMemory(memory_.bytes(), table()));
    if (places.memory_bytes != header.memory_bytes) {
      return Corrupt("it takes other memory than it says");
    }
    for (size_t i = 0; i < sizes_.size(); ++i) {
      sizes_[i].memory_bytes = places.sections[i].bytes;
    }
    TL_ASSIGN_OR_RETURN(memory_, Unpack(memory_.bytes(), table(), places));
  }
  const std::span<const Section> sections = table();
  const SectionReader reader(memory_.bytes(), sections);
  std::span<const char> info_json;
  TL_RETURN_IF_ERROR(reader.Read(kInfo, 0, info_json));
  TL_ASSIGN_OR_RETURN(info_,
                      ModelInfoFromJson({info_json.data(), info_json.size()}));
  for (uint32_t f = 0; f == 0 || reader.Has(kTreeOffsets, f); ++f) {
    if (f == kMaxForests) return Corrupt("too many forests");
    TL_RETURN_IF_ERROR(ReadForest(reader, f, forests_.emplace_back()));
  }
  for (const Section& section : sections) {
    if (section.kind < kFirstExtra) continue;
    TL_RETURN_IF_ERROR(reader.Read(section.kind, 0, extras_[section.kind]));
  }

  info_.format_version = header.version;
  info_.bounds_min_in_world = forests_[0].bounds_min_in_world;
  info_.bounds_max_in_world = forests_[0].bounds_max_in_world;
  for (const ForestView& forest : forests_) {
    info_.bounds_min_in_world =
        Least(info_.bounds_min_in_world, forest.bounds_min_in_world);
    info_.bounds_max_in_world =
        -Least(-info_.bounds_max_in_world, -forest.bounds_max_in_world);
    info_.trees += forest.trees();
    info_.nodes += static_cast<int64_t>(forest.nodes.size());
    info_.leaves += static_cast<int64_t>(forest.payloads.size());
  }
  info_.file_bytes = header.file_bytes;
  info_.memory_bytes = MemoryBytes(header);
  info_.checksum = absl::StrFormat("%016x", header.checksum);
  return absl::OkStatus();
}

std::span<const char> ModelFile::ExtraBytes(ModelExtra kind) const {
  const auto found = extras_.find(static_cast<uint32_t>(kind));
  return found == extras_.end() ? std::span<const char>() : found->second;
}

absl::StatusOr<uint64_t> ReadModelMemoryBytes(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const base::InputFile file, base::InputFile::Open(path));
  const absl::StatusOr<Header> header = ReadHeader(file);
  if (!header.ok()) return base::Annotate(header.status(), path);
  return MemoryBytes(*header);
}

absl::StatusOr<std::string> ReadModelExtra(const std::string& path,
                                           ModelExtra kind,
                                           uint64_t max_bytes) {
  TL_ASSIGN_OR_RETURN(const base::InputFile file, base::InputFile::Open(path));
  const auto read = [&]() -> absl::StatusOr<std::string> {
    TL_ASSIGN_OR_RETURN(const Header header, ReadHeader(file));
    std::vector<Section> sections(header.sections);
    TL_RETURN_IF_ERROR(
        file.ReadAt(sizeof(header), WritableBytes(std::span(sections))));
    const Section* section =
        FindSection(sections, static_cast<uint32_t>(kind), 0);
    if (section == nullptr) {
      return absl::NotFoundError(absl::StrCat("the model has no section ",
                                              static_cast<uint32_t>(kind)));
    }
    TL_RETURN_IF_ERROR(CheckPlace(*section, file.size()));
    // A packed section is shorter than what it becomes.
    if (section->bytes > max_bytes) return Corrupt("a section is too long");
    std::string bytes(section->bytes, '\0');
    TL_RETURN_IF_ERROR(
        file.ReadAt(section->offset, WritableBytes(std::span<char>(bytes))));
    if ((section->kind & kPacked) == 0) return bytes;
    TL_ASSIGN_OR_RETURN(const uint64_t unpacked_bytes, UnpackedBytes(bytes));
    if (unpacked_bytes > max_bytes) return Corrupt("a section is too long");
    std::string unpacked(unpacked_bytes, '\0');
    TL_RETURN_IF_ERROR(
        UnpackSection(bytes, WritableBytes(std::span<char>(unpacked))));
    return unpacked;
  };
  absl::StatusOr<std::string> bytes = read();
  if (!bytes.ok()) return base::Annotate(bytes.status(), path);
  return bytes;
}

}  // namespace treeline::forest

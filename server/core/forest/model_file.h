// The model file: docs/reference/model-format.md specifies it byte by byte.
#ifndef SERVER_CORE_FOREST_MODEL_FILE_H_
#define SERVER_CORE_FOREST_MODEL_FILE_H_

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/core/forest/forest.h"
#include "server/core/forest/model_info.h"
#include "server/core/forest/model_memory.h"

namespace treeline::base {
class InputFile;
}  // namespace treeline::base

namespace treeline::forest {

// 2: sections may be packed. Version 1 is still read.
inline constexpr uint32_t kModelFormatVersion = 2;

// What the sections of a model may take in memory together.
inline constexpr uint64_t kMaxModelMemory_bytes = uint64_t{64} << 30;

// What a file may hold beside its forests. The numbers are the file's.
enum class ModelExtra : uint32_t {
  kKeyframes = 8,
  kKeyframePoints = 9,
  kKeyframeFeatures = 10,
  kSceneDescriptor = 11,
  kKeyframeWords = 12,
  kKeyframeFeatureWords = 13,
  kLeafMeans = 14,
};

// The bytes of one of them; they belong to somebody else.
struct ModelExtraBytes {
  ModelExtra kind;
  absl::string_view bytes;
};

// What a section takes.
struct SectionSize {
  uint32_t kind = 0;    // as docs/reference/model-format.md numbers them
  uint32_t forest = 0;  // which one it is of; 0 if of none
  uint64_t file_bytes = 0;
  uint64_t memory_bytes = 0;  // more where it is packed in the file
};

// The bytes of a model file. At least one forest.
absl::StatusOr<std::string> EncodeModel(
    const ModelInfo& info, const std::vector<ForestView>& forests,
    std::span<const ModelExtraBytes> extras = {});

// Writes the file atomically, sections packed where that is shorter; what is
// read from it later is what was given, to the bit. On failure whatever was at
// `path` stays. info.format_version, trees, nodes, leaves, file_bytes,
// memory_bytes and checksum are taken from the forests and the file, not from
// `info`. At least one forest.
absl::Status WriteModel(const std::string& path, const ModelInfo& info,
                        const std::vector<ForestView>& forests,
                        std::span<const ModelExtraBytes> extras = {});

// A model file read into memory of its own and verified there: magic, version,
// lengths, checksum over all bytes, and ForestView::Validate; packed sections
// are unpacked. What happens to
// the file afterwards does not matter to it. Immutable and thread-safe.
class ModelFile {
 public:
  // NOT_FOUND, PERMISSION_DENIED; DATA_LOSS with the reason for a file that is
  // truncated, corrupt or no model; UNIMPLEMENTED for a newer version;
  // RESOURCE_EXHAUSTED without memory for it; UNAVAILABLE if it cannot be read.
  // Safe on hostile files, and on files that somebody writes to or truncates
  // meanwhile.
  static absl::StatusOr<std::unique_ptr<const ModelFile>> Open(
      const std::string& path);

  const ModelInfo& info() const { return info_; }
  // Points into this object: valid while it lives. All methods have forest 0;
  // points-lines has its line points in forest 1.
  const ForestView& forest(size_t i = 0) const { return forests_[i]; }
  size_t forests() const { return forests_.size(); }
  // In the order of the file.
  const std::vector<SectionSize>& sections() const { return sizes_; }

  // An extra section as values of type T, aligned to 64 bytes; empty if the
  // file has none. DATA_LOSS if its size is no multiple of T's. What is in it
  // must still be checked.
  template <typename T>
  absl::StatusOr<std::span<const T>> Extra(ModelExtra kind) const {
    std::span<const char> bytes = ExtraBytes(kind);
    if (bytes.size() % sizeof(T) != 0) {
      return absl::DataLossError("corrupt model: a section of odd length");
    }
    return std::span<const T>(reinterpret_cast<const T*>(bytes.data()),
                              bytes.size() / sizeof(T));
  }

 private:
  ModelFile() = default;
  absl::Status Read(const base::InputFile& file);
  std::span<const char> ExtraBytes(ModelExtra kind) const;

  ModelMemory memory_;
  ModelInfo info_;
  std::vector<ForestView> forests_;
  std::map<uint32_t, std::span<const char>> extras_;
  std::vector<SectionSize> sizes_;
};

// What a model takes in memory once it is open (ModelInfo::memory_bytes), as
// the file's header has it; the rest of the file is not read. Errors as those
// of ModelFile::Open.
absl::StatusOr<uint64_t> ReadModelMemoryBytes(const std::string& path);

// One extra section of a file, without reading what else is in it: the header,
// the section table and the section's own bounds are checked, the file's
// checksum is not. NOT_FOUND: no such file, or it has no such section.
// DATA_LOSS: it is longer than max_bytes (unpacked), too. Other errors as those
// of ModelFile::Open. Safe on hostile files.
absl::StatusOr<std::string> ReadModelExtra(const std::string& path,
                                           ModelExtra kind, uint64_t max_bytes);

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_MODEL_FILE_H_

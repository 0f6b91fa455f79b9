// The model file: docs/model-format.md specifies it byte by byte.
#ifndef SERVER_CORE_FOREST_MODEL_FILE_H_
#define SERVER_CORE_FOREST_MODEL_FILE_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/file.h"
#include "server/core/forest/forest.h"
#include "server/core/forest/model_info.h"

namespace treeline {

inline constexpr uint32_t kModelFormatVersion = 1;

// Writes the file atomically: on failure whatever was at `path` stays.
// info.format_version, trees, nodes, leaves, file_bytes and checksum are taken
// from the forest and the file, not from `info`.
absl::Status WriteModel(const std::string& path, const ModelInfo& info,
                        const ForestView& forest);

// A model file mapped into memory, verified: magic, version, lengths, checksum
// over all bytes, and ForestView::Validate. Immutable and thread-safe.
class ModelFile {
 public:
  // NOT_FOUND, PERMISSION_DENIED; DATA_LOSS with the reason for a file that is
  // truncated, corrupt or no model; UNIMPLEMENTED for a newer version. Safe on
  // hostile files.
  static absl::StatusOr<std::unique_ptr<const ModelFile>> Open(
      const std::string& path);

  const ModelInfo& info() const { return info_; }
  // Points into the mapping: valid while this object lives.
  const ForestView& forest() const { return forest_; }

 private:
  ModelFile() = default;
  absl::Status Parse();

  MappedFile file_;
  ModelInfo info_;
  ForestView forest_;
};

}  // namespace treeline

#endif  // SERVER_CORE_FOREST_MODEL_FILE_H_

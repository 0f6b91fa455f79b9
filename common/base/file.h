// Whole files in and out. A written file appears complete or not at all.
#ifndef COMMON_BASE_FILE_H_
#define COMMON_BASE_FILE_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

// The bytes of `path`. NOT_FOUND, PERMISSION_DENIED or UNAVAILABLE name the
// path and the system's reason; RESOURCE_EXHAUSTED if it is longer than
// max_bytes.
absl::StatusOr<std::string> ReadFile(const std::string& path,
                                     uint64_t max_bytes = 1u << 30);

// Replaces `path` atomically: writes path + ".tmp-<pid>" beside it, syncs,
// renames. On any failure (full disk) the old file stays and the temporary one
// is removed. Devices, pipes and standard output are written into.
absl::Status WriteFileAtomically(const std::string& path,
                                 absl::string_view contents);

// For the many files of a folder that counts only when all of them are there:
// neither atomic nor synced. UNAVAILABLE and so on with the system's reason.
absl::Status WriteNewFile(const std::string& path, absl::string_view bytes);

// Whether WriteFileAtomically(path) may succeed: its folder exists and can be
// written. Checked before long work whose result goes there.
absl::Status CheckWritable(const std::string& path);

// Makes the folder that `path` lies in, and those above it, where missing.
absl::Status MakeParentFolder(const std::string& path);

// A file mapped read-only and shared, so that processes share its pages.
class MappedFile {
 public:
  static absl::StatusOr<MappedFile> Open(const std::string& path);
  MappedFile() = default;
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();

  // Has the system begin to read all of it, and does not wait for that.
  void Prefetch() const;

  const uint8_t* data() const { return data_; }
  uint64_t size() const { return size_; }

 private:
  const uint8_t* data_ = nullptr;
  uint64_t size_ = 0;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_FILE_H_

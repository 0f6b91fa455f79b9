// A file that is read by place, while others may change it.
#ifndef COMMON_BASE_INPUT_FILE_H_
#define COMMON_BASE_INPUT_FILE_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/descriptor.h"

namespace treeline::base {

// An open regular file. If somebody truncates or overwrites it, reading returns
// an error or other bytes; a mapping of the file would raise SIGBUS instead.
// Thread-safe.
class InputFile {
 public:
  // NOT_FOUND, PERMISSION_DENIED and so on name the path and the system's
  // reason; INVALID_ARGUMENT: not a regular file.
  static absl::StatusOr<InputFile> Open(const std::string& path);

  // In bytes, when it was opened.
  uint64_t size() const { return size_; }

  // Fills `out` with the bytes from `offset` on. DATA_LOSS: the file ends
  // before that. UNAVAILABLE: the system could not read it.
  absl::Status ReadAt(uint64_t offset, std::span<uint8_t> out) const;

  // Has the system begin to read all of it, and does not wait for that.
  void Prefetch() const;

 private:
  InputFile(std::unique_ptr<const Descriptor> file, uint64_t size)
      : file_(std::move(file)), size_(size) {}

  std::unique_ptr<const Descriptor> file_;
  uint64_t size_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_INPUT_FILE_H_

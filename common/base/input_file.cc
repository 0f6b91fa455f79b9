#include "common/base/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::base {

absl::StatusOr<InputFile> InputFile::Open(const std::string& path) {
  auto file = std::make_unique<const Descriptor>(
      open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file->get() < 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("opening ", path));
  }
  struct stat info {};
  if (fstat(file->get(), &info) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("reading ", path));
  }
  if (!S_ISREG(info.st_mode)) {
    return absl::InvalidArgumentError(absl::StrCat(path, " is not a file"));
  }
  return InputFile(std::move(file), static_cast<uint64_t>(info.st_size));
}

absl::Status InputFile::ReadAt(uint64_t offset, std::span<uint8_t> out) const {
  while (!out.empty()) {
    const ssize_t got =
        pread(file_->get(), out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0) {
      if (errno == EINTR) continue;
      return absl::UnavailableError(
          absl::StrCat("reading at byte ", offset, ": ", std::strerror(errno)));
    }
    if (got == 0) {
      return absl::DataLossError(
          absl::StrCat("the file ends at byte ", offset));
    }
    offset += static_cast<uint64_t>(got);
    out = out.subspan(static_cast<size_t>(got));
  }
  return absl::OkStatus();
}

void InputFile::Prefetch() const {
  // A hint: if it fails, reading waits for the disk step by step.
  (void)posix_fadvise(file_->get(), 0, 0, POSIX_FADV_WILLNEED);
}

}  // namespace treeline::base

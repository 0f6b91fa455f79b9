#include "common/base/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/descriptor.h"
#include "common/base/status_macros.h"

namespace treeline::base {
namespace {

absl::Status SystemError(absl::string_view action, const std::string& path) {
  return absl::ErrnoToStatus(errno, absl::StrCat(action, " ", path));
}

absl::Status WriteAll(int fd, absl::string_view contents,
                      const std::string& path) {
  while (!contents.empty()) {
    const ssize_t written = write(fd, contents.data(), contents.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return SystemError("writing", path);
    }
    contents.remove_prefix(static_cast<size_t>(written));
  }
  if (fsync(fd) != 0 && errno != EINVAL && errno != EROFS) {
    return SystemError("syncing", path);
  }
  return absl::OkStatus();
}

enum class Target { kFile, kStandardOutput, kDevice };

// What is at `path`, if anything: a file, what standard output goes to
// (/dev/stdout), or a device or pipe (/dev/null). Another file in the place of
// the last two would take them from whoever else has them.
Target TargetOf(const std::string& path) {
  struct stat info {};
  struct stat output {};
  if (stat(path.c_str(), &info) != 0) return Target::kFile;
  if (fstat(STDOUT_FILENO, &output) == 0 && info.st_dev == output.st_dev &&
      info.st_ino == output.st_ino) {
    return Target::kStandardOutput;
  }
  return S_ISREG(info.st_mode) || S_ISDIR(info.st_mode) ? Target::kFile
                                                        : Target::kDevice;
}

absl::Status WriteInto(Target target, absl::string_view contents,
                       const std::string& path) {
  if (target == Target::kStandardOutput) {
    std::fflush(stdout);
    return WriteAll(STDOUT_FILENO, contents, path);
  }
  const Descriptor device(open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (device.get() < 0) return SystemError("opening", path);
  return WriteAll(device.get(), contents, path);
}

absl::StatusOr<uint64_t> RegularFileSize(int fd, const std::string& path) {
  struct stat info {};
  if (fstat(fd, &info) != 0) return SystemError("reading", path);
  if (!S_ISREG(info.st_mode)) {
    return absl::InvalidArgumentError(absl::StrCat(path, " is not a file"));
  }
  return static_cast<uint64_t>(info.st_size);
}

}  // namespace

absl::StatusOr<std::string> ReadFile(const std::string& path,
                                     uint64_t max_bytes) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return SystemError("opening", path);
  TL_ASSIGN_OR_RETURN(const uint64_t size, RegularFileSize(file.get(), path));
  if (size > max_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat(path, " has ", size, " bytes; at most ", max_bytes,
                     " are accepted here"));
  }
  std::string contents(size, '\0');
  size_t filled = 0;
  while (filled < contents.size()) {
    const ssize_t got =
        read(file.get(), contents.data() + filled, contents.size() - filled);
    if (got < 0) {
      if (errno == EINTR) continue;
      return SystemError("reading", path);
    }
    if (got == 0) break;
    filled += static_cast<size_t>(got);
  }
  contents.resize(filled);
  return contents;
}

absl::Status WriteFileAtomically(const std::string& path,
                                 absl::string_view contents) {
  if (const Target target = TargetOf(path); target != Target::kFile) {
    return WriteInto(target, contents, path);
  }
  const std::string temporary = absl::StrCat(path, ".tmp-", getpid());
  {
    const Descriptor file(open(temporary.c_str(),
                               O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.get() < 0) return SystemError("creating", temporary);
    if (absl::Status status = WriteAll(file.get(), contents, temporary);
        !status.ok()) {
      unlink(temporary.c_str());
      return status;
    }
  }
  if (rename(temporary.c_str(), path.c_str()) != 0) {
    const absl::Status status = SystemError("renaming to", path);
    unlink(temporary.c_str());
    return status;
  }
  return absl::OkStatus();
}

absl::Status WriteNewFile(const std::string& path, absl::string_view bytes) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat("creating ", path));
  }
  errno = 0;
  const bool written =
      std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int write_error = errno;
  const bool closed = std::fclose(file) == 0;
  if (written && closed) return absl::OkStatus();
  return absl::ErrnoToStatus(written ? errno : write_error,
                             absl::StrCat("writing ", path));
}

absl::Status CheckWritable(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, " is a folder; give the name of a file"));
  }
  if (TargetOf(path) != Target::kFile) {
    return access(path.c_str(), W_OK) == 0 ? absl::OkStatus()
                                           : SystemError("writing", path);
  }
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  if (!std::filesystem::is_directory(folder, ignored)) {
    return absl::NotFoundError(
        absl::StrCat("no folder ", folder, " for ", path, "; make it first"));
  }
  if (access(folder.c_str(), W_OK) != 0) {
    return SystemError("cannot write into", folder);
  }
  return absl::OkStatus();
}

absl::Status MakeParentFolder(const std::string& path) {
  const std::filesystem::path folder =
      std::filesystem::path(path).parent_path();
  if (folder.empty()) return absl::OkStatus();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return absl::OkStatus();
  return absl::ErrnoToStatus(
      error.value(), absl::StrCat("cannot make the folder ", folder.string()));
}

absl::StatusOr<MappedFile> MappedFile::Open(const std::string& path) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return SystemError("opening", path);
  MappedFile mapped;
  TL_ASSIGN_OR_RETURN(mapped.size_, RegularFileSize(file.get(), path));
  if (mapped.size_ == 0) return mapped;
  void* address =
      mmap(nullptr, mapped.size_, PROT_READ, MAP_SHARED, file.get(), 0);
  if (address == MAP_FAILED) return SystemError("mapping", path);
  mapped.data_ = static_cast<const uint8_t*>(address);
  return mapped;
}

void MappedFile::Prefetch() const {
  if (data_ == nullptr) return;
  // A hint: if it fails, pages are read when they are touched.
  (void)madvise(const_cast<uint8_t*>(data_), size_, MADV_WILLNEED);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) munmap(const_cast<uint8_t*>(data_), size_);
}

}  // namespace treeline::base

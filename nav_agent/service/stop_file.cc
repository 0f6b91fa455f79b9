#include "nav_agent/service/stop_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::agent_service {
namespace {

constexpr char kFirstLine[] = "treeline-stop 1";
constexpr char kLastLine[] = "end";
constexpr uint64_t kMaxBytes = 4096;

std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char letter) { return static_cast<unsigned char>(letter) < ' '; },
      ' ');
  return text;
}

// An empty file is none that can be understood, and needs no room on the disk.
void Empty(const std::string& path) {
  const int file =
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

}  // namespace

std::string StopFileText(const std::optional<std::string>& why) {
  return absl::StrCat(
      kFirstLine, "\n",
      why.has_value() ? "stopped\n" + OneLine(*why) : "released\n", "\n",
      kLastLine, "\n");
}

absl::StatusOr<std::optional<std::string>> ParseStopFile(
    const std::string& text) {
  const std::vector<std::string> lines = absl::StrSplit(text, '\n');
  if (lines.size() != 5 || lines[0] != kFirstLine || lines[3] != kLastLine ||
      !lines[4].empty()) {
    return absl::InvalidArgumentError("not a stop file, or not all of one");
  }
  if (lines[1] == "stopped") return lines[2];
  if (lines[1] == "released" && lines[2].empty()) return std::nullopt;
  return absl::InvalidArgumentError(
      "neither \"stopped\" nor \"released\" in it");
}

StopFile::StopFile(const std::string& folder) : path_(folder + "/stop") {
  const absl::MutexLock lock(&mutex_);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  Load();
  const absl::Status written = Write();
  if (!written.ok() && !why_.has_value()) {
    why_ = absl::StrCat("no stop could be kept: ", written.message());
  }
}

void StopFile::Load() {
  const absl::StatusOr<std::string> text = base::ReadFile(path_, kMaxBytes);
  if (!text.ok()) {
    if (!absl::IsNotFound(text.status())) {
      why_ = absl::StrCat("whether it was stopped is not known: ",
                          text.status().message());
    }
    return;
  }
  const auto read = ParseStopFile(*text);
  why_ = read.ok()
             ? *read
             : absl::StrCat("whether it was stopped is not known: ", path_,
                            ": ", read.status().message());
}

absl::Status StopFile::Write() const {
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(path_, StopFileText(why_)));
  // The name must outlive a power cut, too.
  const std::string folder = std::filesystem::path(path_).parent_path();
  const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  absl::Status synced;
  if (opened < 0 || ::fsync(opened) != 0) {
    synced = absl::ErrnoToStatus(errno, "syncing " + folder);
  }
  if (opened >= 0) ::close(opened);
  return synced;
}

std::optional<std::string> StopFile::why() const {
  const absl::MutexLock lock(&mutex_);
  return why_;
}

absl::Status StopFile::Hold(const std::string& why) {
  const absl::MutexLock lock(&mutex_);
  if (!why_.has_value()) why_ = OneLine(why);
  if (!is_kept()) {
    return absl::FailedPreconditionError(
        "a restart forgets the stop: the agent runs without --state-dir");
  }
  const absl::Status written = Write();
  if (!written.ok()) Empty(path_);
  return written;
}

absl::Status StopFile::Release() {
  const absl::MutexLock lock(&mutex_);
  why_.reset();
  return is_kept() ? Write() : absl::OkStatus();
}

}  // namespace treeline::agent_service

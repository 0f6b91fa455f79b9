#include "common/base/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"

// POSIX wants programs to declare it themselves.
extern char** environ;

namespace treeline::base {
namespace {

constexpr auto kLook = std::chrono::milliseconds(20);
constexpr size_t kLogTail = 2000;

}  // namespace

absl::StatusOr<std::unique_ptr<ChildProcess>> ChildProcess::Start(
    const std::vector<std::string>& argv, const std::string& log) {
  if (argv.empty()) return absl::InvalidArgumentError("no program was named");
  TL_RETURN_IF_ERROR(base::MakeParentFolder(log));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null",
                                   O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  std::vector<std::string> copies = argv;
  std::vector<char*> arguments;
  arguments.reserve(copies.size() + 1);
  for (std::string& argument : copies) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, argv[0].c_str(), &actions, nullptr,
                                arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    return absl::NotFoundError(
        absl::StrCat("starting ", argv[0], ": ", std::strerror(error)));
  }
  return std::unique_ptr<ChildProcess>(new ChildProcess(pid, argv[0], log));
}

ChildProcess::~ChildProcess() {
  Signal(SIGKILL);
  while (!ExitCode().has_value()) std::this_thread::sleep_for(kLook);
}

void ChildProcess::Signal(int signal) {
  if (!ExitCode().has_value()) kill(pid_, signal);
}

std::optional<int> ChildProcess::ExitCode() {
  if (exit_code_.has_value()) return exit_code_;
  int status = 0;
  const pid_t ended = waitpid(pid_, &status, WNOHANG);
  if (ended == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  } else if (ended < 0 && errno != EINTR) {
    // Somebody else has waited for it.
    exit_code_ = -1;
  }
  return exit_code_;
}

std::string ChildProcess::Log() const {
  absl::StatusOr<std::string> text = base::ReadFile(log_);
  return text.ok() ? *std::move(text) : std::string();
}

absl::Status ChildProcess::Wait(const std::stop_token& stop) {
  while (!ExitCode().has_value()) {
    if (stop.stop_requested()) {
      Signal(SIGKILL);
      return absl::CancelledError(absl::StrCat(name_, " was interrupted"));
    }
    std::this_thread::sleep_for(kLook);
  }
  if (*exit_code_ == 0) return absl::OkStatus();
  const std::string log = Log();
  return absl::UnknownError(absl::StrCat(
      name_, " ended with ", *exit_code_, "; its log, ", log_, ", ends with:\n",
      log.substr(log.size() - std::min(log.size(), kLogTail))));
}

std::string FindProgram(const std::string& program) {
  std::vector<std::string> places;
  if (program.find('/') != std::string::npos) {
    places.push_back(program);
  } else if (const char* path = std::getenv("PATH"); path != nullptr) {
    for (const absl::string_view folder : absl::StrSplit(path, ':')) {
      if (!folder.empty()) places.push_back(absl::StrCat(folder, "/", program));
    }
  }
  for (const std::string& place : places) {
    if (IsFile(place) && access(place.c_str(), X_OK) == 0) return place;
  }
  return "";
}

absl::StatusOr<std::string> SiblingProgram(const std::string& name) {
  std::array<char, PATH_MAX> self{};
  const ssize_t length = readlink("/proc/self/exe", self.data(), self.size());
  if (length <= 0) return absl::NotFoundError("where is this program?");
  const std::string path(self.data(), static_cast<size_t>(length));
  const std::string sibling =
      absl::StrCat(path.substr(0, path.rfind('/') + 1), name);
  if (access(sibling.c_str(), X_OK) != 0) {
    return absl::NotFoundError(
        absl::StrCat("there is no ", sibling,
                     "; build it (scripts/build), or give --server "
                     "HOST:PORT of one that runs already"));
  }
  return sibling;
}

}  // namespace treeline::base

#include "common/base/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
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
  return Spawn(argv, log, -1);
}

absl::StatusOr<std::unique_ptr<ChildProcess>> ChildProcess::StartWithInput(
    const std::vector<std::string>& argv, const std::string& log) {
  std::array<int, 2> ends{-1, -1};
  // A socket, since a pipe raises SIGPIPE where nobody reads.
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return absl::UnavailableError(
        absl::StrCat("input of ", argv[0], ": ", std::strerror(errno)));
  }
  const Descriptor its_end(ends[1]);
  auto our_end = std::make_unique<Descriptor>(ends[0]);
  TL_ASSIGN_OR_RETURN(std::unique_ptr<ChildProcess> child,
                      Spawn(argv, log, its_end.get()));
  child->input_ = std::move(our_end);
  return child;
}

absl::StatusOr<std::unique_ptr<ChildProcess>> ChildProcess::Spawn(
    const std::vector<std::string>& argv, const std::string& log,
    int its_input) {
  if (argv.empty()) return absl::InvalidArgumentError("no program was named");
  TL_RETURN_IF_ERROR(base::MakeParentFolder(log));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  if (its_input >= 0) {
    posix_spawn_file_actions_adddup2(&actions, its_input, STDIN_FILENO);
    // A group of its own: a terminal's Ctrl-C is for the one in front.
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
  } else {
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null",
                                     O_RDONLY, 0);
  }
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  std::vector<std::string> copies = argv;
  std::vector<char*> arguments;
  arguments.reserve(copies.size() + 1);
  for (std::string& argument : copies) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, argv[0].c_str(), &actions, &attributes,
                                arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
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

absl::StatusOr<size_t> ChildProcess::Send(absl::string_view bytes) {
  size_t sent = 0;
  while (input_ != nullptr && sent < bytes.size()) {
    const ssize_t some = send(input_->get(), bytes.data() + sent,
                              bytes.size() - sent, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (some >= 0) {
      sent += static_cast<size_t>(some);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return sent;
    } else if (errno != EINTR) {
      return absl::UnavailableError(
          absl::StrCat(name_, " reads no more: ", std::strerror(errno)));
    }
  }
  return sent;
}

void ChildProcess::CloseInput() { input_.reset(); }

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

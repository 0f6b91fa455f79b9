#include "tests/integration/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "absl/strings/match.h"
#include "absl/strings/str_split.h"

extern char** environ;

namespace treeline {
namespace {

[[noreturn]] void Die(const char* what, const std::string& which, int error) {
  std::fprintf(stderr, "%s %s: %s\n", what, which.c_str(),
               std::strerror(error));
  std::abort();
}

// The complete lines of `text`.
std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines = absl::StrSplit(text, '\n');
  lines.pop_back();
  return lines;
}

std::optional<std::string> FindLine(const std::string& text,
                                    const std::string& prefix) {
  for (const std::string& line : LinesOf(text)) {
    if (absl::StartsWith(line, prefix)) return line;
  }
  return std::nullopt;
}

}  // namespace

Process::Process(const std::vector<std::string>& argv) {
  int out[2];
  int err[2];
  if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) {
    Die("pipe for", argv[0], errno);
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& argument : argv) {
    arguments.push_back(const_cast<char*>(argument.c_str()));
  }
  arguments.push_back(nullptr);
  const int error = posix_spawn(&pid_, argv[0].c_str(), &actions, nullptr,
                                arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) Die("starting", argv[0], error);
  close(out[1]);
  close(err[1]);
  threads_.emplace_back([this, fd = out[0]] { Read(fd, &out_); });
  threads_.emplace_back([this, fd = err[0]] { Read(fd, &err_); });
  threads_.emplace_back([this] {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    absl::MutexLock lock(&mutex_);
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  });
}

Process::~Process() {
  Signal(SIGKILL);
  for (std::thread& thread : threads_) thread.join();
}

void Process::Read(int fd, std::string* text) {
  char buffer[4096];
  while (true) {
    const ssize_t got = read(fd, buffer, sizeof(buffer));
    if (got < 0 && errno == EINTR) continue;
    absl::MutexLock lock(&mutex_);
    if (got <= 0) {
      --open_pipes_;
      break;
    }
    text->append(buffer, static_cast<size_t>(got));
  }
  close(fd);
}

std::optional<std::string> Process::WaitForLine(const std::string& prefix) {
  std::optional<std::string> line;
  const auto seen_or_over = [&]() ABSL_NO_THREAD_SAFETY_ANALYSIS {
    line = FindLine(out_, prefix);
    return line.has_value() || (exit_code_ && open_pipes_ == 0);
  };
  absl::MutexLock lock(&mutex_);
  mutex_.AwaitWithTimeout(absl::Condition(&seen_or_over), kPatience);
  return line;
}

std::optional<int> Process::WaitForExit(absl::Duration patience) {
  const auto over = [&]() ABSL_NO_THREAD_SAFETY_ANALYSIS {
    return exit_code_.has_value() && open_pipes_ == 0;
  };
  absl::MutexLock lock(&mutex_);
  mutex_.AwaitWithTimeout(absl::Condition(&over), patience);
  return exit_code_;
}

bool Process::IsRunning() {
  absl::MutexLock lock(&mutex_);
  return !exit_code_.has_value();
}

void Process::Signal(int signal) {
  absl::MutexLock lock(&mutex_);
  // Once it was waited for, its number may be another's.
  if (!exit_code_) kill(pid_, signal);
}

std::string Process::out() {
  absl::MutexLock lock(&mutex_);
  return out_;
}

std::string Process::err() {
  absl::MutexLock lock(&mutex_);
  return err_;
}

ProgramResult RunProgram(const std::vector<std::string>& argv) {
  Process process(argv);
  const std::optional<int> exit_code = process.WaitForExit();
  if (!exit_code) Die("waiting for", argv[0], ETIMEDOUT);
  return {*exit_code, process.out(), process.err()};
}

}  // namespace treeline

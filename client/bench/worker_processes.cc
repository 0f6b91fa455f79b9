#include "client/bench/worker_processes.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <istream>
#include <ostream>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "nlohmann/json.hpp"

extern char** environ;

namespace treeline::bench {
namespace {

constexpr char kReady[] = "ready";
constexpr char kError[] = "error ";
// How often a stop is looked for.
constexpr int kPollMs = 200;
constexpr size_t kReadBytes = size_t{1} << 16;

std::string StepLine(const LoadStep& step) {
  return nlohmann::json{{"rate_per_s", step.rate_per_s},
                        {"concurrency", step.concurrency},
                        {"seed", step.seed}}
      .dump();
}

absl::StatusOr<LoadStep> ParseStep(const std::string& line) {
  try {
    const nlohmann::json json = nlohmann::json::parse(line);
    return LoadStep{.rate_per_s = json.at("rate_per_s"),
                    .concurrency = json.at("concurrency"),
                    .seed = json.at("seed")};
  } catch (const nlohmann::json::exception& error) {
    return absl::InvalidArgumentError(
        absl::StrCat("no step of a load: ", error.what()));
  }
}

std::string ErrorLine(const absl::Status& status) {
  std::string message(status.message());
  for (char& c : message) {
    if (c == '\n') c = ' ';
  }
  return absl::StrCat(kError, static_cast<int>(status.code()), " ", message);
}

// "error 14 connection refused".
absl::Status ErrorOf(absl::string_view line) {
  absl::ConsumePrefix(&line, kError);
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(line, absl::MaxSplits(' ', 1));
  int code = 0;
  if (!absl::SimpleAtoi(parts.first, &code) || code < 1 || code > 16) {
    return absl::InternalError("a worker process says what none says");
  }
  return absl::Status(static_cast<absl::StatusCode>(code), parts.second);
}

absl::Status SystemError(const char* what) {
  return absl::InternalError(absl::StrCat(what, ": ", std::strerror(errno)));
}

}  // namespace

struct WorkerProcesses::Worker {
  pid_t pid = 0;
  int to = -1;    // its standard input
  int from = -1;  // its standard output
  std::string unread;
};

LoadStep PartOf(const LoadStep& step, int i, int count) {
  return {.rate_per_s = step.rate_per_s / count,
          .concurrency =
              step.concurrency / count + (i < step.concurrency % count ? 1 : 0),
          .seed = step.seed + static_cast<uint64_t>(i)};
}

bool ServeSteps(
    std::istream& in, std::ostream& out,
    const std::function<absl::Status()>& prepare,
    const std::function<absl::StatusOr<RunRecord>(const LoadStep& step)>& run) {
  if (const absl::Status prepared = prepare(); !prepared.ok()) {
    out << ErrorLine(prepared) << std::endl;
    return false;
  }
  out << kReady << std::endl;
  for (std::string line; std::getline(in, line);) {
    const absl::StatusOr<LoadStep> step = ParseStep(line);
    const absl::StatusOr<RunRecord> record =
        step.ok() ? run(*step) : absl::StatusOr<RunRecord>(step.status());
    if (!record.ok()) {
      out << ErrorLine(record.status()) << std::endl;
      return false;
    }
    out << WriteRunRecord(*record) << std::endl;
  }
  return true;
}

absl::Status WorkerProcesses::Spawn(std::vector<std::string> command) {
  int to[2];
  int from[2];
  if (pipe2(to, O_CLOEXEC) != 0) return SystemError("pipe");
  if (pipe2(from, O_CLOEXEC) != 0) {
    close(to[0]);
    close(to[1]);
    return SystemError("pipe");
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, to[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, from[1], STDOUT_FILENO);
  // Of its own group, so that a Ctrl-C comes from here, once.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  std::vector<char*> argv;
  for (std::string& argument : command) argv.push_back(argument.data());
  argv.push_back(nullptr);
  auto worker = std::make_unique<Worker>();
  const int failed = posix_spawn(&worker->pid, argv[0], &actions, &attributes,
                                 argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(to[0]);
  close(from[1]);
  worker->to = to[1];
  worker->from = from[0];
  if (failed != 0) {
    close(worker->to);
    close(worker->from);
    return absl::InternalError(
        absl::StrCat(command[0], ": ", std::strerror(failed)));
  }
  workers_.push_back(std::move(worker));
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<WorkerProcesses>> WorkerProcesses::Start(
    const std::vector<std::string>& command, int count,
    const std::stop_token& stop) {
  // A worker that has ended must not end this process with it.
  std::signal(SIGPIPE, SIG_IGN);
  std::unique_ptr<WorkerProcesses> processes(new WorkerProcesses);
  for (int i = 0; i < count; ++i) {
    std::vector<std::string> numbered = command;
    numbered.push_back(absl::StrCat(i));
    TL_RETURN_IF_ERROR(processes->Spawn(std::move(numbered)));
  }
  for (const std::unique_ptr<Worker>& worker : processes->workers_) {
    TL_ASSIGN_OR_RETURN(const std::string line,
                        processes->ReadLine(*worker, stop));
    if (line != kReady) return ErrorOf(line);
  }
  if (stop.stop_requested()) return absl::CancelledError("interrupted");
  return processes;
}

WorkerProcesses::~WorkerProcesses() {
  for (const std::unique_ptr<Worker>& worker : workers_) {
    close(worker->to);
    close(worker->from);
    // One that waits for a line ends by itself; one in the middle does not.
    kill(worker->pid, SIGTERM);
  }
  for (const std::unique_ptr<Worker>& worker : workers_) {
    int status = 0;
    while (waitpid(worker->pid, &status, 0) < 0 && errno == EINTR) {
    }
  }
}

void WorkerProcesses::Interrupt() {
  if (std::exchange(interrupted_, true)) return;
  for (const std::unique_ptr<Worker>& worker : workers_) {
    kill(worker->pid, SIGINT);
  }
}

absl::StatusOr<std::string> WorkerProcesses::ReadLine(
    Worker& worker, const std::stop_token& stop) {
  while (true) {
    const size_t end = worker.unread.find('\n');
    if (end != std::string::npos) {
      std::string line = worker.unread.substr(0, end);
      worker.unread.erase(0, end + 1);
      return line;
    }
    if (stop.stop_requested()) Interrupt();
    pollfd ready = {.fd = worker.from, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, kPollMs) == 0) continue;
    const size_t size = worker.unread.size();
    worker.unread.resize(size + kReadBytes);
    const ssize_t got =
        read(worker.from, worker.unread.data() + size, kReadBytes);
    const int error = errno;
    worker.unread.resize(size + static_cast<size_t>(std::max<ssize_t>(got, 0)));
    if (got < 0 && error == EINTR) continue;
    if (got <= 0) {
      return stop.stop_requested()
                 ? absl::CancelledError("interrupted")
                 : absl::UnavailableError("a worker process has ended early");
    }
  }
}

absl::StatusOr<LoadRun> WorkerProcesses::Run(const LoadStep& step,
                                             const std::stop_token& stop) {
  const int count = static_cast<int>(workers_.size());
  for (int i = 0; i < count; ++i) {
    const std::string line = StepLine(PartOf(step, i, count)) + "\n";
    const auto written =
        write(workers_[static_cast<size_t>(i)]->to, line.data(), line.size());
    if (written != static_cast<ssize_t>(line.size())) {
      return absl::UnavailableError("a worker process has ended early");
    }
  }
  std::vector<LoadRun> runs;
  std::map<OutcomeKey, int64_t> all_calls;
  for (const std::unique_ptr<Worker>& worker : workers_) {
    TL_ASSIGN_OR_RETURN(const std::string line, ReadLine(*worker, stop));
    if (absl::StartsWith(line, kError)) return ErrorOf(line);
    TL_ASSIGN_OR_RETURN(RunRecord record, ParseRunRecord(line));
    for (const auto& [key, calls] : record.all_calls) all_calls[key] += calls;
    runs.push_back(std::move(record.run));
  }
  all_calls_ = std::move(all_calls);
  return MergeRuns(runs);
}

}  // namespace treeline::bench

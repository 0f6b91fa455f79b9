// Child processes, for tests.
#ifndef TESTS_INTEGRATION_PROCESS_H_
#define TESTS_INTEGRATION_PROCESS_H_

#include <sys/types.h>

#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace treeline {

// Long enough for anything here on a busy machine; nothing waits for it to
// pass.
inline constexpr absl::Duration kPatience = absl::Seconds(150);

// A running program with captured output. Killed when destroyed.
class Process {
 public:
  // argv[0] is the path of the program. Dies if it cannot be started.
  explicit Process(const std::vector<std::string>& argv);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  // The first line on standard output that starts with `prefix`, as soon as it
  // is there. nullopt: the program ended without it, or lost our patience.
  std::optional<std::string> WaitForLine(const std::string& prefix);

  // The exit code, or minus the signal that ended it. nullopt: still running
  // after `patience`.
  std::optional<int> WaitForExit(absl::Duration patience = kPatience);
  bool IsRunning();
  pid_t pid() const { return pid_; }

  void Signal(int signal);

  // What was written so far; everything, once WaitForExit has returned a code.
  std::string out();
  std::string err();

 private:
  void Read(int fd, std::string* text);

  pid_t pid_ = 0;
  absl::Mutex mutex_;
  std::string out_ ABSL_GUARDED_BY(mutex_);
  std::string err_ ABSL_GUARDED_BY(mutex_);
  int open_pipes_ ABSL_GUARDED_BY(mutex_) = 2;
  std::optional<int> exit_code_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> threads_;
};

// Runs a program to its end.
struct ProgramResult {
  int exit_code = 0;
  std::string out;
  std::string err;
};
ProgramResult RunProgram(const std::vector<std::string>& argv);

}  // namespace treeline

#endif  // TESTS_INTEGRATION_PROCESS_H_

// A program that runs beside this one.
#ifndef COMMON_BASE_CHILD_PROCESS_H_
#define COMMON_BASE_CHILD_PROCESS_H_

#include <sys/types.h>

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/descriptor.h"

namespace treeline::base {

// Killed, and waited for, when destroyed. Not thread-safe.
class ChildProcess {
 public:
  // argv[0] is the program's path. What it writes goes to `log`, which is
  // replaced. NOT_FOUND if there is no such program.
  static absl::StatusOr<std::unique_ptr<ChildProcess>> Start(
      const std::vector<std::string>& argv, const std::string& log);
  // With standard input, which Send fills; Ctrl-C does not reach it. It sees
  // the end of its input when this program ends, however that does.
  static absl::StatusOr<std::unique_ptr<ChildProcess>> StartWithInput(
      const std::vector<std::string>& argv, const std::string& log);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // SIGKILL, SIGSTOP, ... Nothing once it has ended.
  void Signal(int signal);
  // Its exit code, or minus the signal that ended it; nullopt while it runs.
  std::optional<int> ExitCode();
  // Waits until it has ended. UNKNOWN, with the end of its log, if its exit
  // code is not 0; CANCELLED, and it is killed, if `stop` is requested.
  absl::Status Wait(const std::stop_token& stop);
  // Hands over so much of `bytes` as there is room for now, and returns how
  // much that was. UNAVAILABLE: it reads no more.
  absl::StatusOr<size_t> Send(absl::string_view bytes);
  // The end of its input.
  void CloseInput();
  // What it has written so far.
  std::string Log() const;

 private:
  ChildProcess(pid_t pid, std::string name, std::string log)
      : pid_(pid), name_(std::move(name)), log_(std::move(log)) {}
  // its_input: a descriptor, or negative: /dev/null.
  static absl::StatusOr<std::unique_ptr<ChildProcess>> Spawn(
      const std::vector<std::string>& argv, const std::string& log,
      int its_input);

  pid_t pid_;
  std::unique_ptr<Descriptor> input_;  // our end
  std::string name_;
  std::string log_;
  std::optional<int> exit_code_;
};

// Where the shell would find `program`: a path as it is, a name in the folders
// of PATH. Empty: there is none that may be run.
std::string FindProgram(const std::string& program);

// The path of a program that lies beside this one: "treeline-server".
// NOT_FOUND, with what to do, if it is not there.
absl::StatusOr<std::string> SiblingProgram(const std::string& name);

}  // namespace treeline::base

#endif  // COMMON_BASE_CHILD_PROCESS_H_

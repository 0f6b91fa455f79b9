// A stop that outlives the program: the file that keeps it.
#ifndef NAV_AGENT_SERVICE_STOP_FILE_H_
#define NAV_AGENT_SERVICE_STOP_FILE_H_

#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"

namespace treeline::agent_service {

// Thread-safe. Whatever goes wrong, the robot starts stopped: a file that
// cannot be understood, or a folder that cannot be written, is a stop.
class StopFile {
 public:
  // No folder: nothing is kept.
  StopFile() = default;
  // Makes the folder, reads `folder`/stop, and writes it again to see that it
  // can.
  explicit StopFile(const std::string& folder);

  bool is_kept() const { return !path_.empty(); }
  // Why the robot is stopped; nullopt: it is not. Newlines are spaces.
  std::optional<std::string> why() const;

  // What a restart finds from now on. An error says what is wrong with the
  // file: after Hold a restart finds a stop nevertheless, if not this reason
  // (FAILED_PRECONDITION without a folder); after Release it may find the old
  // one.
  absl::Status Hold(const std::string& why);
  absl::Status Release();

 private:
  void Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Write() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  std::string path_;
  mutable absl::Mutex mutex_;
  std::optional<std::string> why_ ABSL_GUARDED_BY(mutex_);
};

// The bytes of a stop file, and back. INVALID_ARGUMENT: not one.
std::string StopFileText(const std::optional<std::string>& why);
absl::StatusOr<std::optional<std::string>> ParseStopFile(
    const std::string& text);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_STOP_FILE_H_

// The bearer token that calls carry.
#ifndef CLIENT_RELOCALIZER_TOKEN_SOURCE_H_
#define CLIENT_RELOCALIZER_TOKEN_SOURCE_H_

#include <sys/stat.h>

#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client/relocalizer/connect_options.h"

namespace treeline::relocalizer {

// A token from a file, which whoever renews it replaces, or a fixed one.
// Thread-safe.
class TokenSource {
 public:
  // What the options say; null: no token.
  static absl::StatusOr<std::unique_ptr<TokenSource>> Open(
      const ConnectOptions& options);
  // The file's content without white space around it. As ReadFile;
  // INVALID_ARGUMENT if there is nothing in it, or what no token has. No error
  // says what was in it.
  static absl::StatusOr<std::unique_ptr<TokenSource>> FromFile(
      const std::string& path);
  // NOT_FOUND: no such variable.
  static absl::StatusOr<std::unique_ptr<TokenSource>> FromEnvironment(
      const std::string& variable);

  // The token as it is now. If the file has become unreadable or empty, the
  // last good one: it may be about to be replaced, and the server decides
  // whether it still counts.
  std::string Get();

 private:
  // What tells one state of a file from another.
  struct FileState {
    dev_t device = 0;
    ino_t inode = 0;
    off_t bytes = 0;
    timespec changed = {};
    bool operator==(const FileState& other) const;
  };

  TokenSource(std::string path, std::string token);
  static FileState StateOf(const std::string& path);

  const std::string path_;  // empty: fixed
  absl::Mutex mutex_;
  FileState state_ ABSL_GUARDED_BY(mutex_);
  std::string token_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_TOKEN_SOURCE_H_

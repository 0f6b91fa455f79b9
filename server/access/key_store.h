// The keys in a file or a folder, read again when they change.
#ifndef SERVER_ACCESS_KEY_STORE_H_
#define SERVER_ACCESS_KEY_STORE_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/access/jwt_keys.h"
#include "server/access/poll_gate.h"
#include "server/access/trust_log.h"

namespace treeline::access {

struct KeyStoreOptions {
  // A JSON Web Key Set, or a folder of public keys <kid>.pem.
  std::string path = {};
  // Keys of other algorithms are passed over. HS256 only if it is named, since
  // its keys are secrets that everyone who verifies could sign with.
  std::vector<JwtAlgorithm> algorithms = {
      JwtAlgorithm::kRs256, JwtAlgorithm::kEs256, JwtAlgorithm::kEdDsa};
  // How often the files are looked at, 10 ms or more.
  std::chrono::milliseconds poll_interval = std::chrono::seconds(1);

  absl::Status Validate() const;
};

// Thread-safe.
class KeyStore {
 public:
  struct Snapshot {
    std::shared_ptr<const JwtKeySet> keys;
    // Another one whenever the keys are others.
    uint64_t generation = 0;
  };

  // INVALID_ARGUMENT, NOT_FOUND, PERMISSION_DENIED...: the keys cannot be used;
  // the message names the file. `clock` must outlive the store.
  static absl::StatusOr<std::unique_ptr<KeyStore>> Open(
      const KeyStoreOptions& options, const base::Clock& clock, TrustLog log);

  // The keys as they are now. At most once in an interval the caller's thread
  // looks whether the files have other contents: contents that cannot be used
  // leave the keys as they were, and are logged once.
  Snapshot Current();

 private:
  KeyStore(const KeyStoreOptions& options, const base::Clock& clock,
           TrustLog log);

  // Names and bytes of the files; one without a name: it is a key set.
  using Files = std::vector<std::pair<std::string, std::string>>;

  absl::StatusOr<Files> ReadFiles() const;
  absl::StatusOr<JwtKeySet> Parse(const Files& files) const;
  // Takes the keys if the files are others than the last ones. Whether it did.
  absl::StatusOr<bool> Load();
  void Poll();

  const KeyStoreOptions options_;
  const base::Clock& clock_;
  const TrustLog log_;
  PollGate gate_;
  // Touched only by the thread that the gate let in.
  std::optional<Files> files_;
  std::string last_error_;

  absl::Mutex mutex_;
  Snapshot snapshot_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_KEY_STORE_H_

// Tokens to claims, remembered for as long as they hold.
#ifndef SERVER_ACCESS_TOKEN_VERIFIER_H_
#define SERVER_ACCESS_TOKEN_VERIFIER_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "server/access/key_store.h"
#include "server/access/lru_map.h"
#include "server/access/token_claims.h"
#include "server/access/wall_clock.h"

namespace treeline::access {

struct TokenVerifierOptions {
  ClaimRules rules = {};
  // Valid tokens that are remembered, 0..1000000, about 400 bytes each. Of
  // those that no key of ours has signed, a tenth as many are.
  size_t cache_size = 10000;

  absl::Status Validate() const;
};

// Thread-safe.
class TokenVerifier {
 public:
  // `options` are valid. The references must outlive the verifier.
  TokenVerifier(const TokenVerifierOptions& options, KeyStore& keys,
                const WallClock& clock);

  // UNAUTHENTICATED with TOKEN_INVALID or TOKEN_EXPIRED. What was verified with
  // keys that have since been replaced is verified again.
  absl::StatusOr<TokenClaims> Verify(absl::string_view token);

  // Signatures that were checked, since construction; the rest was remembered.
  int64_t signatures_checked() const;

 private:
  // What is known about a token; nullopt: nothing.
  std::optional<absl::StatusOr<TokenClaims>> Remembered(
      const std::string& digest, uint64_t generation, int64_t now);

  const TokenVerifierOptions options_;
  KeyStore& keys_;
  const WallClock& clock_;

  mutable absl::Mutex mutex_;
  // By the SHA-256 of the token; tokens themselves are not kept.
  LruMap<TokenClaims> accepted_ ABSL_GUARDED_BY(mutex_);
  // Signatures that did not fit, apart from the others, so that forged tokens
  // push out no good ones.
  LruMap<absl::Status> refused_ ABSL_GUARDED_BY(mutex_);
  // The keys that all entries were verified with.
  uint64_t generation_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t signatures_checked_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_TOKEN_VERIFIER_H_

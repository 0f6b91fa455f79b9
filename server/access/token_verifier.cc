#include "server/access/token_verifier.h"

#include <openssl/sha.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/access/jwt.h"

namespace treeline::access {
namespace {

std::string DigestOf(absl::string_view token) {
  std::string digest(SHA256_DIGEST_LENGTH, '\0');
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(),
         reinterpret_cast<unsigned char*>(digest.data()));
  return digest;
}

}  // namespace

absl::Status TokenVerifierOptions::Validate() const {
  if (cache_size > 1000000) {
    return absl::InvalidArgumentError(absl::StrCat(
        "tokens remembered: ", cache_size, "; it must be 0..1000000"));
  }
  return rules.Validate();
}

TokenVerifier::TokenVerifier(const TokenVerifierOptions& options,
                             KeyStore& keys, const WallClock& clock)
    : options_(options),
      keys_(keys),
      clock_(clock),
      accepted_(options.cache_size),
      refused_(options.cache_size / 10) {}

std::optional<absl::StatusOr<TokenClaims>> TokenVerifier::Remembered(
    const std::string& digest, uint64_t generation, int64_t now) {
  const absl::MutexLock lock(&mutex_);
  // A thread that comes late with older keys must not bring them back.
  if (generation > generation_) {
    accepted_.Clear();
    refused_.Clear();
    generation_ = generation;
  }
  if (const TokenClaims* claims = accepted_.Find(digest); claims != nullptr) {
    const absl::Status expiry =
        CheckExpiry(claims->expires_unix_s, options_.rules, now);
    if (!expiry.ok()) return expiry;
    return *claims;
  }
  if (const absl::Status* why = refused_.Find(digest); why != nullptr) {
    return *why;
  }
  ++signatures_checked_;
  return std::nullopt;
}

absl::StatusOr<TokenClaims> TokenVerifier::Verify(absl::string_view token) {
  if (token.size() > kLongestToken) {
    return base::WithReason(
        absl::UnauthenticatedError(
            absl::StrCat("the token is longer than ", kLongestToken, " bytes")),
        "TOKEN_INVALID");
  }
  const KeyStore::Snapshot keys = keys_.Current();
  const int64_t now = clock_.UnixSeconds();
  const std::string digest = DigestOf(token);
  if (auto known = Remembered(digest, keys.generation, now)) {
    return *std::move(known);
  }
  const absl::StatusOr<std::string> json =
      VerifyJwtSignature(token, *keys.keys);
  if (!json.ok()) {
    const absl::MutexLock lock(&mutex_);
    if (keys.generation == generation_) refused_.Insert(digest, json.status());
    return json.status();
  }
  TL_ASSIGN_OR_RETURN(TokenClaims claims,
                      ParseTokenClaims(*json, options_.rules, now));
  const absl::MutexLock lock(&mutex_);
  if (keys.generation == generation_) accepted_.Insert(digest, claims);
  return claims;
}

int64_t TokenVerifier::signatures_checked() const {
  const absl::MutexLock lock(&mutex_);
  return signatures_checked_;
}

}  // namespace treeline::access

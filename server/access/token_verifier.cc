#include "server/access/token_verifier.h"

#include <openssl/sha.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/access/jwt.h"

namespace treeline {
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
    : options_(options), keys_(keys), clock_(clock) {}

absl::StatusOr<TokenClaims> TokenVerifier::Verify(absl::string_view token) {
  if (token.size() > kLongestToken) {
    return WithReason(
        absl::UnauthenticatedError(
            absl::StrCat("the token is longer than ", kLongestToken, " bytes")),
        "TOKEN_INVALID");
  }
  const KeyStore::Snapshot keys = keys_.Current();
  const int64_t now = clock_.UnixSeconds();
  std::string digest = DigestOf(token);
  {
    const absl::MutexLock lock(&mutex_);
    // A thread that comes late with older keys must not bring them back.
    if (keys.generation > generation_) {
      entries_.clear();
      by_digest_.clear();
      generation_ = keys.generation;
    }
    const auto found = by_digest_.find(digest);
    if (found != by_digest_.end()) {
      TL_RETURN_IF_ERROR(CheckExpiry(found->second->claims.expires_unix_s,
                                     options_.rules, now));
      entries_.splice(entries_.begin(), entries_, found->second);
      return entries_.front().claims;
    }
    ++signatures_checked_;
  }
  TL_ASSIGN_OR_RETURN(const std::string json,
                      VerifyJwtSignature(token, *keys.keys));
  TL_ASSIGN_OR_RETURN(TokenClaims claims,
                      ParseTokenClaims(json, options_.rules, now));

  const absl::MutexLock lock(&mutex_);
  if (keys.generation == generation_ && options_.cache_size > 0 &&
      !by_digest_.contains(digest)) {
    entries_.push_front({digest, claims});
    by_digest_[std::move(digest)] = entries_.begin();
    if (entries_.size() > options_.cache_size) {
      by_digest_.erase(entries_.back().digest);
      entries_.pop_back();
    }
  }
  return claims;
}

int64_t TokenVerifier::signatures_checked() const {
  const absl::MutexLock lock(&mutex_);
  return signatures_checked_;
}

}  // namespace treeline

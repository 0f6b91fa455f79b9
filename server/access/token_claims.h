// What a token says, once its signature has been checked.
#ifndef SERVER_ACCESS_TOKEN_CLAIMS_H_
#define SERVER_ACCESS_TOKEN_CLAIMS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::access {

struct ClaimRules {
  // "iss" must be this; empty: any issuer whose key we have.
  std::string issuer = {};
  // "aud" must be or hold this. Not empty: a token that was made for another
  // service must not work here.
  std::string audience = "treeline";
  // How far clocks may differ: 0..300 s.
  int64_t leeway_s = 30;

  absl::Status Validate() const;
};

struct TokenClaims {
  // "sub": 1 to 256 bytes.
  std::string subject = {};
  // Of "scope" (words in one text, RFC 8693) and "scp" (a text or an array).
  bool may_localize = false;
  bool may_administer = false;
  bool may_inspect = false;
  // "rate": requests per second, above 0; 0: nothing said.
  double rate_per_s = 0;
  // "exp".
  int64_t expires_unix_s = 0;
};

// Reads the claims of a verified token and checks "exp", which it must have,
// "nbf", "iat", "iss" and "aud" at the time `now_unix_s`.
//   UNAUTHENTICATED  TOKEN_EXPIRED: "exp" has passed. TOKEN_INVALID: all else.
absl::StatusOr<TokenClaims> ParseTokenClaims(absl::string_view json,
                                             const ClaimRules& rules,
                                             int64_t now_unix_s);

// Whether "exp" has passed, as ParseTokenClaims answers it.
absl::Status CheckExpiry(int64_t expires_unix_s, const ClaimRules& rules,
                         int64_t now_unix_s);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_TOKEN_CLAIMS_H_

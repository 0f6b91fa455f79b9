// The signature of a JSON Web Token (RFC 7519, RFC 7515), by libjwt and,
// of Ed25519, which libjwt does not know, by OpenSSL.
#ifndef SERVER_ACCESS_JWT_H_
#define SERVER_ACCESS_JWT_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/access/jwt_keys.h"

namespace treeline::access {

// Longer tokens are refused before anything looks into them.
inline constexpr size_t kLongestToken = 8 * 1024;  // bytes

// Checks the form and the signature of a token in the compact serialization,
// and returns its claims as JSON text; it does not look at them. The key is the
// one that "kid" and "alg" of the header name; a token whose header has "crit"
// is refused, since we understand no extension. UNAUTHENTICATED with
// TOKEN_INVALID: all else. Thread-safe.
absl::StatusOr<std::string> VerifyJwtSignature(absl::string_view token,
                                               const JwtKeySet& keys);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_JWT_H_

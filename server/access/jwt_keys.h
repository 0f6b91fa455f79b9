// The keys that tokens are verified with. Each is bound to one algorithm, so
// that a public key is never taken for an HMAC secret.
#ifndef SERVER_ACCESS_JWT_KEYS_H_
#define SERVER_ACCESS_JWT_KEYS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::access {

// RFC 7518, section 3.1, and Ed25519 of RFC 8037. There is no kNone, and there
// shall not be.
enum class JwtAlgorithm { kRs256, kEs256, kEdDsa, kHs256 };

// "RS256".
const char* NameOf(JwtAlgorithm algorithm);
// Also "Ed25519", as RFC 9864 calls EdDSA. INVALID_ARGUMENT: no such algorithm,
// or one that is not offered ("none").
absl::StatusOr<JwtAlgorithm> ParseJwtAlgorithm(absl::string_view name);

struct JwtKey {
  // What tokens name it by ("kid"); empty: it has no name.
  std::string id = {};
  JwtAlgorithm algorithm = JwtAlgorithm::kRs256;
  // kHs256: the secret, 32 bytes or more. Else: the public key as PEM
  // (SubjectPublicKeyInfo).
  std::string material = {};
};

class JwtKeySet {
 public:
  JwtKeySet() = default;
  // INVALID_ARGUMENT: two keys have one id, or there are more than 64.
  static absl::StatusOr<JwtKeySet> Make(std::vector<JwtKey> keys);

  // The key that a token names. Without a name, the only key of the algorithm;
  // nullptr if there is none, or if several could be meant.
  const JwtKey* Find(absl::string_view id, JwtAlgorithm algorithm) const;

  const std::vector<JwtKey>& keys() const { return keys_; }

 private:
  std::vector<JwtKey> keys_;
};

// A JSON Web Key Set (RFC 7517). Keys of types, uses and algorithms that are
// not among `allowed` are passed over, as the standard asks. INVALID_ARGUMENT,
// with the key's place: malformed; RSA of less than 2048 or more than 8192
// bits, or with an exponent that makes signatures worthless; a point that is
// not on P-256; an Ed25519 point of small order, for which everybody can sign;
// a secret of less than 32 bytes; or keys of which none is left.
// {"keys": []} is a set: it makes every token invalid.
absl::StatusOr<JwtKeySet> ParseJwks(absl::string_view json,
                                    const std::vector<JwtAlgorithm>& allowed);

// A public key, or a certificate that holds one, as PEM: RS256 for RSA, ES256
// for P-256 and EdDSA for Ed25519. INVALID_ARGUMENT as above, and for a private
// key, which has no business on a server that only verifies.
absl::StatusOr<JwtKey> ParsePemJwtKey(absl::string_view id,
                                      absl::string_view pem);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_JWT_KEYS_H_

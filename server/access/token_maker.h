// Keys and tokens, as an issuer would make them. For tests.
#ifndef SERVER_ACCESS_TOKEN_MAKER_H_
#define SERVER_ACCESS_TOKEN_MAKER_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/access/jwt_keys.h"

namespace treeline::access {

// A private key as PEM. Each dies on failure.
std::string MakeRsaPrivateKey(int bits = 2048);
std::string MakeEcPrivateKey(const char* curve = "P-256");
std::string MakeEd25519PrivateKey();
// Its public part as PEM.
std::string PublicKeyOf(const std::string& private_key);

// Its public part as one JSON Web Key, with `more` members ("\"use\":\"sig\"").
std::string RsaJwk(const std::string& private_key, const std::string& id,
                   const std::string& more = "");
std::string EcJwk(const std::string& private_key, const std::string& id);
std::string Ed25519Jwk(const std::string& private_key, const std::string& id);
std::string SecretJwk(const std::string& secret, const std::string& id);
// {"keys": [...]}.
std::string Jwks(const std::vector<std::string>& keys);

// A token with these claims (JSON), signed by libjwt or OpenSSL. `id` empty: no
// "kid".
std::string MakeToken(JwtAlgorithm algorithm, const std::string& private_key,
                      const std::string& id, const std::string& claims);

// header.claims.signature of these bytes, whatever they are.
std::string JoinToken(absl::string_view header, absl::string_view claims,
                      absl::string_view signature);

// HMAC-SHA256 of "header.claims" with `secret`: a token as one forges it.
std::string MakeHmacToken(absl::string_view header, absl::string_view claims,
                          absl::string_view secret);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_TOKEN_MAKER_H_

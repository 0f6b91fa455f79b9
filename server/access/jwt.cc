#include "server/access/jwt.h"

#include <jwt.h>
#include <openssl/pem.h>

#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/access/base64url.h"
#include "server/access/openssl.h"

namespace treeline::access {
namespace {

using Json = nlohmann::json;

struct FreeJwt {
  void operator()(jwt_t* jwt) const { jwt_free(jwt); }
};
struct FreeText {
  void operator()(char* text) const { std::free(text); }
};

absl::Status Invalid(absl::string_view what) {
  return base::WithReason(
      absl::UnauthenticatedError(absl::StrCat("the token is invalid: ", what)),
      "TOKEN_INVALID");
}

jwt_alg_t ToLibjwt(JwtAlgorithm algorithm) {
  switch (algorithm) {
    case JwtAlgorithm::kRs256:
      return JWT_ALG_RS256;
    case JwtAlgorithm::kEs256:
      return JWT_ALG_ES256;
    case JwtAlgorithm::kHs256:
      return JWT_ALG_HS256;
    case JwtAlgorithm::kEdDsa:
      break;
  }
  return JWT_ALG_INVAL;
}

absl::StatusOr<const JwtKey*> KeyFor(const std::string& header_json,
                                     const JwtKeySet& keys) {
  const Json header =
      Json::parse(header_json, nullptr, /*allow_exceptions=*/false);
  if (!header.is_object() || !header.contains("alg") ||
      !header["alg"].is_string()) {
    return Invalid("its header is malformed");
  }
  if (header.contains("crit")) return Invalid("it needs an extension");
  const auto algorithm = ParseJwtAlgorithm(header["alg"].get<std::string>());
  if (!algorithm.ok()) return Invalid("its algorithm is not accepted");
  std::string id;
  if (header.contains("kid")) {
    if (!header["kid"].is_string()) return Invalid("its header is malformed");
    id = header["kid"].get<std::string>();
  }
  const JwtKey* key = keys.Find(id, *algorithm);
  if (key == nullptr) return Invalid("no known key could have signed it");
  return key;
}

// RFC 8037, section 3.1: the signature is of the two first parts as they are
// written.
absl::StatusOr<std::string> VerifyByOpenSsl(
    const std::vector<absl::string_view>& parts, const JwtKey& key) {
  const BioPtr bio = ReadingBio(key.material);
  const PkeyPtr pkey(PEM_read_bio_PUBKEY(bio.get(), nullptr, nullptr, nullptr));
  const DigestContextPtr context(EVP_MD_CTX_new());
  const std::string text = absl::StrCat(parts[0], ".", parts[1]);
  const std::string signature = *DecodeBase64Url(parts[2]);
  if (pkey == nullptr || context == nullptr ||
      EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr,
                           pkey.get()) != 1 ||
      EVP_DigestVerify(context.get(),
                       reinterpret_cast<const unsigned char*>(signature.data()),
                       signature.size(),
                       reinterpret_cast<const unsigned char*>(text.data()),
                       text.size()) != 1) {
    TakeOpenSslError();
    return Invalid("its signature is wrong");
  }
  const Json claims = Json::parse(*DecodeBase64Url(parts[1]), nullptr,
                                  /*allow_exceptions=*/false);
  if (!claims.is_object()) return Invalid("it holds no claims");
  return claims.dump();
}

absl::StatusOr<std::string> VerifyByLibjwt(absl::string_view token,
                                           const JwtKey& key) {
  jwt_t* decoded = nullptr;
  const int error =
      jwt_decode(&decoded, std::string(token).c_str(),
                 reinterpret_cast<const unsigned char*>(key.material.data()),
                 static_cast<int>(key.material.size()));
  const std::unique_ptr<jwt_t, FreeJwt> jwt(decoded);
  if (error != 0 || jwt == nullptr) {
    return Invalid("its signature is wrong, or it has no claims");
  }
  // libjwt chose the algorithm by the token. That it was the key's is what
  // keeps a public key from being used as an HMAC secret.
  if (jwt_get_alg(jwt.get()) != ToLibjwt(key.algorithm)) {
    return Invalid("its algorithm is not that of its key");
  }
  const std::unique_ptr<char, FreeText> claims(
      jwt_get_grants_json(jwt.get(), nullptr));
  if (claims == nullptr || *claims != '{') {
    return Invalid("it holds no claims");
  }
  return std::string(claims.get());
}

}  // namespace

absl::StatusOr<std::string> VerifyJwtSignature(absl::string_view token,
                                               const JwtKeySet& keys) {
  if (token.size() > kLongestToken) {
    return Invalid(absl::StrCat("longer than ", kLongestToken, " bytes"));
  }
  // libjwt passes over what is not Base64 and has its own idea of where parts
  // end, so it only sees what is well-formed.
  const std::vector<absl::string_view> parts = absl::StrSplit(token, '.');
  if (parts.size() != 3) return Invalid("not three parts");
  std::optional<std::string> header;
  for (const absl::string_view part : parts) {
    std::optional<std::string> bytes = DecodeBase64Url(part);
    if (!bytes || bytes->empty()) return Invalid("a part is malformed");
    if (!header) header = std::move(bytes);
  }
  TL_ASSIGN_OR_RETURN(const JwtKey* key, KeyFor(*header, keys));
  return key->algorithm == JwtAlgorithm::kEdDsa ? VerifyByOpenSsl(parts, *key)
                                                : VerifyByLibjwt(token, *key);
}

}  // namespace treeline::access

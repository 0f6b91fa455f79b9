#include "server/access/token_maker.h"

#include <jwt.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/hmac.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>

#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/access/base64url.h"
#include "server/access/openssl.h"

namespace treeline::access {
namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

std::string PrivatePem(EVP_PKEY* key) {
  Require(key != nullptr);
  const PkeyPtr owner(key);
  const BioPtr bio(BIO_new(BIO_s_mem()));
  Require(PEM_write_bio_PrivateKey(bio.get(), key, nullptr, nullptr, 0, nullptr,
                                   nullptr) == 1);
  return Written(*bio);
}

// Unsigned, big-endian, of `size` bytes or as many as it needs.
std::string Number(const EVP_PKEY& key, const char* name, int size = 0) {
  BIGNUM* number = nullptr;
  Require(EVP_PKEY_get_bn_param(&key, name, &number) == 1);
  const BignumPtr owner(number);
  if (size == 0) size = BN_num_bytes(number);
  std::string bytes(static_cast<size_t>(size), '\0');
  Require(BN_bn2binpad(number, reinterpret_cast<unsigned char*>(bytes.data()),
                       size) == size);
  return EncodeBase64Url(bytes);
}

std::string MakeEd25519Token(const std::string& private_key,
                             const std::string& id, const std::string& claims) {
  const PkeyPtr key = ReadPrivateKey(private_key);
  const std::string header =
      absl::StrCat(R"({"alg":"EdDSA")", id.empty() ? "" : R"(,"kid":")", id,
                   id.empty() ? "" : "\"", "}");
  const std::string text =
      absl::StrCat(EncodeBase64Url(header), ".", EncodeBase64Url(claims));
  const DigestContextPtr context(EVP_MD_CTX_new());
  std::string signature(64, '\0');
  size_t size = signature.size();
  Require(EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr,
                             key.get()) == 1);
  Require(EVP_DigestSign(
              context.get(), reinterpret_cast<unsigned char*>(signature.data()),
              &size, reinterpret_cast<const unsigned char*>(text.data()),
              text.size()) == 1);
  return absl::StrCat(text, ".", EncodeBase64Url(signature));
}

jwt_alg_t ToLibjwt(JwtAlgorithm algorithm) {
  if (algorithm == JwtAlgorithm::kHs256) return JWT_ALG_HS256;
  return algorithm == JwtAlgorithm::kRs256 ? JWT_ALG_RS256 : JWT_ALG_ES256;
}

}  // namespace

std::string MakeRsaPrivateKey(int bits) {
  return PrivatePem(EVP_RSA_gen(static_cast<unsigned>(bits)));
}

std::string MakeEcPrivateKey(const char* curve) {
  return PrivatePem(EVP_EC_gen(curve));
}

std::string MakeEd25519PrivateKey() {
  return PrivatePem(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
}

std::string PublicKeyOf(const std::string& private_key) {
  const PkeyPtr key = ReadPrivateKey(private_key);
  const BioPtr bio(BIO_new(BIO_s_mem()));
  Require(PEM_write_bio_PUBKEY(bio.get(), key.get()) == 1);
  return Written(*bio);
}

std::string RsaJwk(const std::string& private_key, const std::string& id,
                   const std::string& more) {
  const PkeyPtr key = ReadPrivateKey(private_key);
  return absl::StrCat(R"({"kty":"RSA","kid":")", id, R"(","n":")",
                      Number(*key, OSSL_PKEY_PARAM_RSA_N), R"(","e":")",
                      Number(*key, OSSL_PKEY_PARAM_RSA_E), "\"",
                      more.empty() ? "" : ",", more, "}");
}

std::string EcJwk(const std::string& private_key, const std::string& id) {
  const PkeyPtr key = ReadPrivateKey(private_key);
  return absl::StrCat(R"({"kty":"EC","crv":"P-256","kid":")", id, R"(","x":")",
                      Number(*key, OSSL_PKEY_PARAM_EC_PUB_X, 32), R"(","y":")",
                      Number(*key, OSSL_PKEY_PARAM_EC_PUB_Y, 32), "\"}");
}

std::string Ed25519Jwk(const std::string& private_key, const std::string& id) {
  const PkeyPtr key = ReadPrivateKey(private_key);
  std::string x(32, '\0');
  size_t size = x.size();
  Require(EVP_PKEY_get_raw_public_key(
              key.get(), reinterpret_cast<unsigned char*>(x.data()), &size) ==
          1);
  return absl::StrCat(R"({"kty":"OKP","crv":"Ed25519","kid":")", id,
                      R"(","x":")", EncodeBase64Url(x), "\"}");
}

std::string SecretJwk(const std::string& secret, const std::string& id) {
  return absl::StrCat(R"({"kty":"oct","kid":")", id, R"(","k":")",
                      EncodeBase64Url(secret), "\"}");
}

std::string Jwks(const std::vector<std::string>& keys) {
  return absl::StrCat(R"({"keys":[)", absl::StrJoin(keys, ","), "]}");
}

std::string MakeToken(JwtAlgorithm algorithm, const std::string& private_key,
                      const std::string& id, const std::string& claims) {
  if (algorithm == JwtAlgorithm::kEdDsa) {
    return MakeEd25519Token(private_key, id, claims);
  }
  jwt_t* jwt = nullptr;
  Require(jwt_new(&jwt) == 0);
  if (!id.empty()) Require(jwt_add_header(jwt, "kid", id.c_str()) == 0);
  Require(jwt_add_grants_json(jwt, claims.c_str()) == 0);
  Require(
      jwt_set_alg(jwt, ToLibjwt(algorithm),
                  reinterpret_cast<const unsigned char*>(private_key.data()),
                  static_cast<int>(private_key.size())) == 0);
  char* text = jwt_encode_str(jwt);
  Require(text != nullptr);
  std::string token = text;
  std::free(text);
  jwt_free(jwt);
  return token;
}

std::string JoinToken(absl::string_view header, absl::string_view claims,
                      absl::string_view signature) {
  return absl::StrCat(EncodeBase64Url(header), ".", EncodeBase64Url(claims),
                      ".", EncodeBase64Url(signature));
}

std::string MakeHmacToken(absl::string_view header, absl::string_view claims,
                          absl::string_view secret) {
  const std::string text =
      absl::StrCat(EncodeBase64Url(header), ".", EncodeBase64Url(claims));
  std::string mac(EVP_MAX_MD_SIZE, '\0');
  unsigned size = 0;
  Require(HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
               reinterpret_cast<const unsigned char*>(text.data()), text.size(),
               reinterpret_cast<unsigned char*>(mac.data()), &size) != nullptr);
  mac.resize(size);
  return absl::StrCat(text, ".", EncodeBase64Url(mac));
}

}  // namespace treeline::access

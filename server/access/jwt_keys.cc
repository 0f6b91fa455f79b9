#include "server/access/jwt_keys.h"

#include <openssl/core_names.h>
#include <openssl/pem.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/access/base64url.h"
#include "server/access/openssl.h"

namespace treeline::access {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxKeys = 64;
constexpr size_t kShortestSecret = 32;  // bytes: RFC 7518, section 3.2
constexpr int kFewestRsaBits = 2048;
constexpr int kMaxRsaBits = 8192;
constexpr size_t kLongestExponent = 8;  // bytes
constexpr size_t kEd25519Bytes = 32;

absl::Status Bad(absl::string_view what) {
  return absl::InvalidArgumentError(what);
}

// A member that holds text; empty if it is missing or something else.
std::string Text(const Json& object, const char* name) {
  const auto member = object.find(name);
  if (member == object.end() || !member->is_string()) return "";
  return member->get<std::string>();
}

absl::StatusOr<std::string> Bytes(const Json& object, const char* name,
                                  size_t most) {
  const std::optional<std::string> bytes = DecodeBase64Url(Text(object, name));
  if (!bytes || bytes->empty() || bytes->size() > most) {
    return Bad(absl::StrCat("'", name, "' is missing, malformed or too long"));
  }
  return *bytes;
}

BignumPtr ToBignum(absl::string_view big_endian) {
  return BignumPtr(
      BN_bin2bn(reinterpret_cast<const unsigned char*>(big_endian.data()),
                static_cast<int>(big_endian.size()), nullptr));
}

PkeyPtr MakePublicKey(const char* type, OSSL_PARAM_BLD* builder) {
  const ParamsPtr params(OSSL_PARAM_BLD_to_param(builder));
  const PkeyContextPtr context(
      EVP_PKEY_CTX_new_from_name(nullptr, type, nullptr));
  EVP_PKEY* key = nullptr;
  if (params == nullptr || context == nullptr ||
      EVP_PKEY_fromdata_init(context.get()) != 1 ||
      EVP_PKEY_fromdata(context.get(), &key, EVP_PKEY_PUBLIC_KEY,
                        params.get()) != 1) {
    return nullptr;
  }
  return PkeyPtr(key);
}

absl::StatusOr<PkeyPtr> RsaKey(const Json& jwk) {
  TL_ASSIGN_OR_RETURN(const std::string modulus,
                      Bytes(jwk, "n", kMaxRsaBits / 8));
  TL_ASSIGN_OR_RETURN(const std::string exponent,
                      Bytes(jwk, "e", kLongestExponent));
  const BignumPtr n = ToBignum(modulus);
  const BignumPtr e = ToBignum(exponent);
  const ParamsBuilderPtr builder(OSSL_PARAM_BLD_new());
  OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_N, n.get());
  OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_E, e.get());
  PkeyPtr key = MakePublicKey("RSA", builder.get());
  if (key == nullptr) return Bad(TakeOpenSslError());
  return key;
}

absl::StatusOr<PkeyPtr> P256Key(const Json& jwk) {
  TL_ASSIGN_OR_RETURN(const std::string x, Bytes(jwk, "x", 32));
  TL_ASSIGN_OR_RETURN(const std::string y, Bytes(jwk, "y", 32));
  if (x.size() != 32 || y.size() != 32) {
    return Bad("'x' and 'y' must have 32 bytes");
  }
  const std::string point = absl::StrCat("\x04", x, y);
  const ParamsBuilderPtr builder(OSSL_PARAM_BLD_new());
  OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME,
                                  "prime256v1", 0);
  OSSL_PARAM_BLD_push_octet_string(builder.get(), OSSL_PKEY_PARAM_PUB_KEY,
                                   point.data(), point.size());
  PkeyPtr key = MakePublicKey("EC", builder.get());
  if (key == nullptr) return Bad("the point is not on P-256");
  return key;
}

absl::StatusOr<PkeyPtr> Ed25519Key(const Json& jwk) {
  TL_ASSIGN_OR_RETURN(const std::string x, Bytes(jwk, "x", kEd25519Bytes));
  PkeyPtr key(EVP_PKEY_new_raw_public_key(
      EVP_PKEY_ED25519, nullptr,
      reinterpret_cast<const unsigned char*>(x.data()), x.size()));
  if (key == nullptr) {
    TakeOpenSslError();
    return Bad(absl::StrCat("'x' must have ", kEd25519Bytes, " bytes"));
  }
  return key;
}

// OpenSSL verifies with every point. Those of small order (1, 2, 4 and 8: y is
// 0, 1, -1 or one of two others, written canonically or not) would make
// signatures worthless.
absl::Status CheckEd25519(const EVP_PKEY& key) {
  std::array<unsigned char, kEd25519Bytes> y = {};
  size_t size = y.size();
  if (EVP_PKEY_get_raw_public_key(&key, y.data(), &size) != 1 ||
      size != y.size()) {
    return Bad(TakeOpenSslError());
  }
  // The sign of x.
  y.back() &= 0x7f;
  const std::string hex = absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(y.data()), y.size()));
  const std::string zeros(2 * kEd25519Bytes - 2, '0');
  const std::string ones(2 * kEd25519Bytes - 4, 'f');
  for (const std::string& small :
       {"00" + zeros, "01" + zeros, "ec" + ones + "7f", "ed" + ones + "7f",
        "ee" + ones + "7f",
        std::string("26e8958fc2b227b045c3f489f2ef98f0"
                    "d5dfac05d3c63339b13802886d53fc05"),
        std::string("c7176a703d4dd84fba3c0b760d10670f"
                    "2a2053fa2c39ccc64ec7fd7792ac037a")}) {
    if (hex == small) return Bad("an Ed25519 point of small order");
  }
  return absl::OkStatus();
}

absl::Status CheckRsa(const EVP_PKEY& key) {
  const int bits = EVP_PKEY_get_bits(&key);
  if (bits < kFewestRsaBits || bits > kMaxRsaBits) {
    return Bad(absl::StrCat("RSA of ", bits, " bits; it must have ",
                            kFewestRsaBits, " to ", kMaxRsaBits));
  }
  BIGNUM* modulus = nullptr;
  BIGNUM* exponent = nullptr;
  EVP_PKEY_get_bn_param(&key, OSSL_PKEY_PARAM_RSA_N, &modulus);
  EVP_PKEY_get_bn_param(&key, OSSL_PKEY_PARAM_RSA_E, &exponent);
  const BignumPtr n(modulus);
  const BignumPtr e(exponent);
  // With the exponent 1, everyone can sign.
  if (n == nullptr || e == nullptr || !BN_is_odd(n.get()) ||
      !BN_is_odd(e.get()) || BN_num_bits(e.get()) < 2 ||
      BN_num_bytes(e.get()) > static_cast<int>(kLongestExponent)) {
    return Bad("RSA with a bad modulus or exponent");
  }
  return absl::OkStatus();
}

// The key as JwtKey has it, if it is one that we verify with.
absl::StatusOr<JwtKey> ToJwtKey(absl::string_view id, const EVP_PKEY& key) {
  JwtKey result = {.id = std::string(id)};
  if (EVP_PKEY_is_a(&key, "RSA")) {
    TL_RETURN_IF_ERROR(CheckRsa(key));
    result.algorithm = JwtAlgorithm::kRs256;
  } else if (EVP_PKEY_is_a(&key, "EC")) {
    char group[32] = "";
    EVP_PKEY_get_group_name(&key, group, sizeof(group), nullptr);
    if (absl::string_view(group) != "prime256v1") {
      return Bad("an elliptic curve that is not P-256");
    }
    result.algorithm = JwtAlgorithm::kEs256;
  } else if (EVP_PKEY_is_a(&key, "ED25519")) {
    TL_RETURN_IF_ERROR(CheckEd25519(key));
    result.algorithm = JwtAlgorithm::kEdDsa;
  } else {
    return Bad("neither RSA nor P-256 nor Ed25519");
  }
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_PUBKEY(bio.get(), &key) != 1) {
    return Bad(TakeOpenSslError());
  }
  result.material = Written(*bio);
  return result;
}

// What a JWK is for, as far as we can use it; nullopt: nothing of ours.
std::optional<JwtAlgorithm> AlgorithmOf(const Json& jwk) {
  const std::string type = Text(jwk, "kty");
  const std::string name = Text(jwk, "alg");
  if (const std::string use = Text(jwk, "use"); !use.empty() && use != "sig") {
    return std::nullopt;
  }
  std::optional<JwtAlgorithm> algorithm;
  if (type == "RSA") algorithm = JwtAlgorithm::kRs256;
  if (type == "EC" && Text(jwk, "crv") == "P-256") {
    algorithm = JwtAlgorithm::kEs256;
  }
  if (type == "OKP" && Text(jwk, "crv") == "Ed25519") {
    algorithm = JwtAlgorithm::kEdDsa;
  }
  if (type == "oct") algorithm = JwtAlgorithm::kHs256;
  if (name.empty()) return algorithm;
  const auto named = ParseJwtAlgorithm(name);
  return named.ok() && algorithm == *named ? algorithm : std::nullopt;
}

absl::StatusOr<JwtKey> ParseJwk(const Json& jwk, JwtAlgorithm algorithm) {
  const std::string id = Text(jwk, "kid");
  switch (algorithm) {
    case JwtAlgorithm::kHs256: {
      TL_ASSIGN_OR_RETURN(std::string secret, Bytes(jwk, "k", 1024));
      if (secret.size() < kShortestSecret) {
        return Bad(absl::StrCat("a secret of ", secret.size(),
                                " bytes; it must have at least ",
                                kShortestSecret));
      }
      return JwtKey{id, algorithm, std::move(secret)};
    }
    case JwtAlgorithm::kRs256: {
      TL_ASSIGN_OR_RETURN(const PkeyPtr key, RsaKey(jwk));
      return ToJwtKey(id, *key);
    }
    case JwtAlgorithm::kEs256: {
      TL_ASSIGN_OR_RETURN(const PkeyPtr key, P256Key(jwk));
      return ToJwtKey(id, *key);
    }
    case JwtAlgorithm::kEdDsa: {
      TL_ASSIGN_OR_RETURN(const PkeyPtr key, Ed25519Key(jwk));
      return ToJwtKey(id, *key);
    }
  }
  return absl::InternalError("no such algorithm");
}

}  // namespace

const char* NameOf(JwtAlgorithm algorithm) {
  switch (algorithm) {
    case JwtAlgorithm::kRs256:
      return "RS256";
    case JwtAlgorithm::kEs256:
      return "ES256";
    case JwtAlgorithm::kEdDsa:
      return "EdDSA";
    case JwtAlgorithm::kHs256:
      return "HS256";
  }
  return "";
}

absl::StatusOr<JwtAlgorithm> ParseJwtAlgorithm(absl::string_view name) {
  for (const JwtAlgorithm algorithm :
       {JwtAlgorithm::kRs256, JwtAlgorithm::kEs256, JwtAlgorithm::kEdDsa,
        JwtAlgorithm::kHs256}) {
    if (name == NameOf(algorithm)) return algorithm;
  }
  if (name == "Ed25519") return JwtAlgorithm::kEdDsa;
  return Bad(absl::StrCat("no algorithm of tokens '", name,
                          "'; it must be RS256, ES256, EdDSA or HS256"));
}

absl::StatusOr<JwtKeySet> JwtKeySet::Make(std::vector<JwtKey> keys) {
  if (keys.size() > kMaxKeys) {
    return Bad(absl::StrCat(keys.size(), " keys; at most ", kMaxKeys));
  }
  for (size_t i = 0; i < keys.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (!keys[i].id.empty() && keys[i].id == keys[j].id) {
        return Bad(absl::StrCat("two keys '", keys[i].id, "'"));
      }
    }
  }
  JwtKeySet set;
  set.keys_ = std::move(keys);
  return set;
}

const JwtKey* JwtKeySet::Find(absl::string_view id,
                              JwtAlgorithm algorithm) const {
  const JwtKey* found = nullptr;
  for (const JwtKey& key : keys_) {
    if (key.algorithm != algorithm) continue;
    if (!id.empty()) {
      if (key.id == id) return &key;
      continue;
    }
    if (found != nullptr) return nullptr;
    found = &key;
  }
  return found;
}

absl::StatusOr<JwtKeySet> ParseJwks(absl::string_view json,
                                    const std::vector<JwtAlgorithm>& allowed) {
  const Json set = Json::parse(json.begin(), json.end(), nullptr,
                               /*allow_exceptions=*/false);
  if (!set.is_object() || !set.contains("keys") || !set["keys"].is_array()) {
    return Bad("not a JSON object with an array 'keys'");
  }
  std::vector<JwtKey> keys;
  size_t index = 0;
  for (const Json& jwk : set["keys"]) {
    const std::string where = absl::StrCat("keys[", index++, "]");
    if (index > kMaxKeys) return Bad("too many keys");
    if (!jwk.is_object()) return Bad(absl::StrCat(where, ": not an object"));
    const std::optional<JwtAlgorithm> algorithm = AlgorithmOf(jwk);
    if (!algorithm || std::find(allowed.begin(), allowed.end(), *algorithm) ==
                          allowed.end()) {
      continue;
    }
    auto key = ParseJwk(jwk, *algorithm);
    if (!key.ok()) return base::Annotate(key.status(), where);
    keys.push_back(*std::move(key));
  }
  if (keys.empty() && index > 0) {
    return Bad("no key of an algorithm that is allowed");
  }
  return JwtKeySet::Make(std::move(keys));
}

absl::StatusOr<JwtKey> ParsePemJwtKey(absl::string_view id,
                                      absl::string_view pem) {
  if (pem.find("PRIVATE KEY-----") != absl::string_view::npos) {
    return Bad("a private key; the server needs the public one alone");
  }
  const std::vector<X509Ptr> certificates = ReadCertificates(pem);
  if (!certificates.empty()) {
    const EVP_PKEY* key = X509_get0_pubkey(certificates.front().get());
    if (key == nullptr) return Bad(TakeOpenSslError());
    return ToJwtKey(id, *key);
  }
  const BioPtr bio = ReadingBio(pem);
  const PkeyPtr key(PEM_read_bio_PUBKEY(bio.get(), nullptr, nullptr, nullptr));
  if (key == nullptr) {
    TakeOpenSslError();
    return Bad("neither a public key nor a certificate in PEM");
  }
  return ToJwtKey(id, *key);
}

}  // namespace treeline::access

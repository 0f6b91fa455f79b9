#include "server/access/jwt_keys.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "server/access/base64url.h"
#include "server/access/token_maker.h"

namespace treeline::access {
namespace {

const std::vector<JwtAlgorithm> kAll = {
    JwtAlgorithm::kRs256, JwtAlgorithm::kEs256, JwtAlgorithm::kEdDsa,
    JwtAlgorithm::kHs256};

std::string ErrorOf(const std::string& jwks) {
  const auto keys = ParseJwks(jwks, kAll);
  return keys.ok() ? "OK" : std::string(keys.status().message());
}

TEST(JwtAlgorithm, IsNeverNone) {
  EXPECT_TRUE(ParseJwtAlgorithm("RS256").ok());
  EXPECT_EQ(*ParseJwtAlgorithm("Ed25519"), *ParseJwtAlgorithm("EdDSA"));
  for (const char* name : {"none", "None", "", "rs256", "HS512", "PS256"}) {
    EXPECT_FALSE(ParseJwtAlgorithm(name).ok()) << name;
  }
}

TEST(ParseJwks, GivesTheSameKeysAsPem) {
  const std::string rsa = MakeRsaPrivateKey();
  const std::string ec = MakeEcPrivateKey();
  const std::string ed = MakeEd25519PrivateKey();
  const std::string secret(32, 's');
  const auto keys =
      ParseJwks(Jwks({RsaJwk(rsa, "r"), EcJwk(ec, "e"), Ed25519Jwk(ed, "d"),
                      SecretJwk(secret, "h")}),
                kAll);
  ASSERT_TRUE(keys.ok()) << keys.status();
  const JwtKey* key = keys->Find("r", JwtAlgorithm::kRs256);
  ASSERT_NE(key, nullptr);
  EXPECT_EQ(key->material, PublicKeyOf(rsa));
  key = keys->Find("e", JwtAlgorithm::kEs256);
  ASSERT_NE(key, nullptr);
  EXPECT_EQ(key->material, PublicKeyOf(ec));
  key = keys->Find("d", JwtAlgorithm::kEdDsa);
  ASSERT_NE(key, nullptr);
  EXPECT_EQ(key->material, PublicKeyOf(ed));
  key = keys->Find("h", JwtAlgorithm::kHs256);
  ASSERT_NE(key, nullptr);
  EXPECT_EQ(key->material, secret);
}

TEST(JwtKeySet, FindsAKeyOnlyForItsAlgorithm) {
  const std::string rsa = RsaJwk(MakeRsaPrivateKey(), "r");
  const auto keys = ParseJwks(Jwks({rsa}), kAll);
  ASSERT_TRUE(keys.ok());
  EXPECT_EQ(keys->Find("r", JwtAlgorithm::kHs256), nullptr);
  EXPECT_EQ(keys->Find("R", JwtAlgorithm::kRs256), nullptr);
  EXPECT_NE(keys->Find("", JwtAlgorithm::kRs256), nullptr);
}

TEST(JwtKeySet, DoesNotGuessBetweenTwoKeys) {
  const std::string ec = MakeEcPrivateKey();
  const auto keys = ParseJwks(Jwks({EcJwk(ec, "a"), EcJwk(ec, "b")}), kAll);
  ASSERT_TRUE(keys.ok());
  EXPECT_EQ(keys->Find("", JwtAlgorithm::kEs256), nullptr);
  EXPECT_EQ(keys->Find("b", JwtAlgorithm::kEs256)->id, "b");
}

TEST(ParseJwks, PassesOverWhatIsNotAllowedOrNotForSignatures) {
  const std::string rsa = MakeRsaPrivateKey();
  const auto keys =
      ParseJwks(Jwks({RsaJwk(rsa, "sig", R"("use":"sig","alg":"RS256")"),
                      RsaJwk(rsa, "enc", R"("use":"enc")"),
                      RsaJwk(rsa, "pss", R"("alg":"PS256")"),
                      SecretJwk(std::string(32, 's'), "secret"),
                      R"({"kty":"OKP","crv":"Ed25519","x":"AA"})",
                      R"({"kty":"EC","crv":"P-384","x":"AA","y":"AA"})"}),
                {JwtAlgorithm::kRs256});
  ASSERT_TRUE(keys.ok()) << keys.status();
  ASSERT_EQ(keys->keys().size(), 1u);
  EXPECT_EQ(keys->keys()[0].id, "sig");
}

// For the neutral element everybody can sign everything: R = neutral, S = 0.
TEST(ParseJwks, RefusesEd25519PointsOfSmallOrder) {
  for (const std::string& y :
       {std::string("\1") + std::string(31, '\0'), std::string(32, '\0'),
        std::string("\1") + std::string(30, '\0') + "\x80",
        "\xec" + std::string(30, '\xff') + "\x7f"}) {
    EXPECT_EQ(
        ErrorOf(Jwks({absl::StrCat(R"({"kty":"OKP","crv":"Ed25519","x":")",
                                   EncodeBase64Url(y), "\"}")})),
        "keys[0]: an Ed25519 point of small order");
  }
  EXPECT_EQ(ErrorOf(R"({"keys":[{"kty":"OKP","crv":"Ed25519","x":"AA"}]})"),
            "keys[0]: 'x' must have 32 bytes");
}

TEST(ParseJwks, TakesNoKeysButNotKeysThatAreAllUseless) {
  EXPECT_EQ(ErrorOf(R"({"keys":[]})"), "OK");
  EXPECT_NE(ErrorOf(R"({"keys":[{"kty":"OKP"}]})"), "OK");
}

TEST(ParseJwks, RefusesWeakKeysAndSaysWhich) {
  const std::string good = EcJwk(MakeEcPrivateKey(), "good");
  EXPECT_EQ(ErrorOf(Jwks({good, RsaJwk(MakeRsaPrivateKey(1024), "r")})),
            "keys[1]: RSA of 1024 bits; it must have 2048 to 8192");
  EXPECT_EQ(ErrorOf(Jwks({SecretJwk("short", "h")})),
            "keys[0]: a secret of 5 bytes; it must have at least 32");
  // Everyone can sign with the exponent 1.
  const std::string n = EncodeBase64Url(std::string(256, '\xff'));
  EXPECT_EQ(ErrorOf(absl::StrCat(R"({"keys":[{"kty":"RSA","n":")", n,
                                 R"(","e":"AQ"}]})")),
            "keys[0]: RSA with a bad modulus or exponent");
  const std::string x = EncodeBase64Url(std::string(32, '\x01'));
  EXPECT_EQ(ErrorOf(absl::StrCat(R"({"keys":[{"kty":"EC","crv":"P-256","x":")",
                                 x, R"(","y":")", x, R"("}]})")),
            "keys[0]: the point is not on P-256");
}

TEST(ParseJwks, RefusesTwoKeysOfOneName) {
  const std::string key = EcJwk(MakeEcPrivateKey(), "a");
  EXPECT_EQ(ErrorOf(Jwks({key, key})), "two keys 'a'");
}

TEST(ParseJwks, RefusesWhatIsNoSet) {
  for (const char* json : {"", "[]", "{}", R"({"keys":7})", R"({"keys":[)",
                           R"({"keys":[7]})", R"({"keys":[{"kty":"RSA"}]})",
                           R"({"keys":[{"kty":"oct","k":"a=="}]})"}) {
    EXPECT_NE(ErrorOf(json), "OK") << json;
  }
}

TEST(ParsePemJwtKey, TakesPublicKeysOnly) {
  const std::string ec = MakeEcPrivateKey();
  const auto key = ParsePemJwtKey("k", PublicKeyOf(ec));
  ASSERT_TRUE(key.ok()) << key.status();
  EXPECT_EQ(key->algorithm, JwtAlgorithm::kEs256);
  EXPECT_EQ(key->id, "k");
  EXPECT_FALSE(ParsePemJwtKey("k", ec).ok());
  EXPECT_FALSE(ParsePemJwtKey("k", "").ok());
  EXPECT_FALSE(
      ParsePemJwtKey("k", PublicKeyOf(MakeEcPrivateKey("P-384"))).ok());
  EXPECT_FALSE(ParsePemJwtKey("k", PublicKeyOf(MakeRsaPrivateKey(1024))).ok());
}

}  // namespace
}  // namespace treeline::access

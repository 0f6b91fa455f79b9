#include "server/access/jwt.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/access/base64url.h"
#include "server/access/token_maker.h"

namespace treeline::access {
namespace {

using testing::HasSubstr;

const char kClaims[] = R"({"sub":"robot-7"})";

class JwtTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    rsa_ = new std::string(MakeRsaPrivateKey());
    ec_ = new std::string(MakeEcPrivateKey());
    ed_ = new std::string(MakeEd25519PrivateKey());
  }
  static void TearDownTestSuite() {
    delete rsa_;
    delete ec_;
    delete ed_;
  }

  // What is wrong with the token; "OK" if nothing is.
  std::string ErrorOf(const std::string& token) const {
    const auto claims = VerifyJwtSignature(token, keys_);
    if (claims.ok()) return "OK";
    EXPECT_EQ(claims.status().code(), absl::StatusCode::kUnauthenticated);
    EXPECT_EQ(base::ErrorInfoOf(claims.status()).reason, "TOKEN_INVALID");
    return std::string(claims.status().message());
  }

  static std::string* rsa_;
  static std::string* ec_;
  static std::string* ed_;
  const std::string secret_ = std::string(32, 's');
  const JwtKeySet keys_ =
      *JwtKeySet::Make({{"r", JwtAlgorithm::kRs256, PublicKeyOf(*rsa_)},
                        {"e", JwtAlgorithm::kEs256, PublicKeyOf(*ec_)},
                        {"d", JwtAlgorithm::kEdDsa, PublicKeyOf(*ed_)},
                        {"h", JwtAlgorithm::kHs256, secret_}});
};

std::string* JwtTest::rsa_ = nullptr;
std::string* JwtTest::ec_ = nullptr;
std::string* JwtTest::ed_ = nullptr;

TEST_F(JwtTest, AcceptsEveryAlgorithmWithItsKey) {
  const std::string tokens[] = {
      MakeToken(JwtAlgorithm::kRs256, *rsa_, "r", kClaims),
      MakeToken(JwtAlgorithm::kEs256, *ec_, "e", kClaims),
      MakeToken(JwtAlgorithm::kHs256, secret_, "h", kClaims),
      MakeToken(JwtAlgorithm::kEdDsa, *ed_, "d", kClaims),
      MakeToken(JwtAlgorithm::kEdDsa, *ed_, "", kClaims),
      MakeToken(JwtAlgorithm::kEs256, *ec_, "", kClaims)};
  for (const std::string& token : tokens) {
    const auto claims = VerifyJwtSignature(token, keys_);
    ASSERT_TRUE(claims.ok()) << claims.status();
    EXPECT_EQ(*claims, kClaims);
  }
}

// RFC 7515, appendix A.1: made by someone else.
TEST_F(JwtTest, AcceptsTheExampleOfTheStandard) {
  const auto keys = ParseJwks(
      R"({"keys":[{"kty":"oct","k":"AyM1SysPpbyDfgZld3umj1qzKObwVMkoqQ-EstJQL)"
      R"(r_T-1qS0gZH75aKtMN3Yj0iPS4hcgUuTwjAzZr1Z9CAow"}]})",
      {JwtAlgorithm::kHs256});
  ASSERT_TRUE(keys.ok()) << keys.status();
  const auto claims = VerifyJwtSignature(
      "eyJ0eXAiOiJKV1QiLA0KICJhbGciOiJIUzI1NiJ9.eyJpc3MiOiJqb2UiLA0KICJleHAiO"
      "jEzMDA4MTkzODAsDQogImh0dHA6Ly9leGFtcGxlLmNvbS9pc19yb290Ijp0cnVlfQ.dBjf"
      "tJeZ4CVP-mB92K27uhbUJU1p1r_wW1gFWFOEjXk",
      *keys);
  ASSERT_TRUE(claims.ok()) << claims.status();
  EXPECT_THAT(*claims, HasSubstr("1300819380"));
}

TEST_F(JwtTest, RefusesTokensWithoutASignature) {
  for (const char* none : {"none", "None", "NONE", "nOnE", ""}) {
    const std::string header =
        absl::StrCat(R"({"alg":")", none, R"(","kid":"r"})");
    EXPECT_THAT(ErrorOf(JoinToken(header, kClaims, "x")),
                HasSubstr("algorithm is not accepted"));
    EXPECT_THAT(ErrorOf(JoinToken(header, kClaims, "")),
                HasSubstr("a part is malformed"));
  }
  const std::string token =
      MakeToken(JwtAlgorithm::kRs256, *rsa_, "r", kClaims);
  EXPECT_NE(ErrorOf(token.substr(0, token.rfind('.') + 1)), "OK");
  EXPECT_NE(ErrorOf(token.substr(0, token.rfind('.'))), "OK");
}

TEST_F(JwtTest, DoesNotTakeAPublicKeyForASecret) {
  const std::string pem = PublicKeyOf(*rsa_);
  EXPECT_THAT(
      ErrorOf(MakeHmacToken(R"({"alg":"HS256","kid":"r"})", kClaims, pem)),
      HasSubstr("no known key"));
  // Without a name it is tried with the secret, and does not fit.
  EXPECT_THAT(ErrorOf(MakeHmacToken(R"({"alg":"HS256"})", kClaims, pem)),
              HasSubstr("signature"));
}

// What the header says twice, two readers may read differently. Whichever
// counts, the key's own algorithm is the only one that gets through.
TEST_F(JwtTest, DoesNotTakeAPublicKeyForASecretWhoeverReadsTheHeader) {
  const std::string pem = PublicKeyOf(*rsa_);
  for (const char* header : {R"({"alg":"HS256","alg":"RS256","kid":"r"})",
                             R"({"alg":"RS256","alg":"HS256","kid":"r"})",
                             R"({"alg":"RS256","kid":"r","ALG":"HS256"})",
                             "{\"alg\":\"RS256\",\"kid\":\"r\","
                             "\"alg\\u0000\":\"HS256\"}"}) {
    EXPECT_NE(ErrorOf(MakeHmacToken(header, kClaims, pem)), "OK") << header;
  }
}

// RFC 8037, appendix A: its payload is no claims, which is found out only once
// the signature is right.
TEST(Jwt, VerifiesTheExampleOfTheStandard) {
  const auto keys =
      ParseJwks(R"({"keys":[{"kty":"OKP","crv":"Ed25519",)"
                R"("x":"11qYAYKxCrfVS_7TyWQHOg7hcvPapiMlrwIaaPcHURo"}]})",
                {JwtAlgorithm::kEdDsa});
  ASSERT_TRUE(keys.ok()) << keys.status();
  const std::string text =
      "eyJhbGciOiJFZERTQSJ9.RXhhbXBsZSBvZiBFZDI1NTE5IHNpZ25pbmc.";
  const std::string signature =
      "hgyY0il_MGCjP0JzlnLWG1PPOt7-09PGcvMg3AIbQR6dWbhijcNR4ki4iylGjg5BhVsPt9g7"
      "sVvpAr_MuM0KAg";
  EXPECT_THAT(VerifyJwtSignature(text + signature, *keys).status().message(),
              HasSubstr("no claims"));
  EXPECT_THAT(VerifyJwtSignature(text + "i" + signature.substr(1), *keys)
                  .status()
                  .message(),
              HasSubstr("signature"));
}

TEST_F(JwtTest, TakesAnEd25519KeyForNothingElse) {
  const std::string pem = PublicKeyOf(*ed_);
  // As a secret, for another algorithm, and cut short.
  EXPECT_THAT(
      ErrorOf(MakeHmacToken(R"({"alg":"HS256","kid":"d"})", kClaims, pem)),
      HasSubstr("no known key"));
  EXPECT_THAT(
      ErrorOf(MakeHmacToken(R"({"alg":"EdDSA","kid":"d"})", kClaims, pem)),
      HasSubstr("signature"));
  EXPECT_THAT(ErrorOf(JoinToken(R"({"alg":"EdDSA","kid":"e"})", kClaims, "s")),
              HasSubstr("no known key"));
  EXPECT_THAT(ErrorOf(MakeToken(JwtAlgorithm::kEdDsa, *ed_, "d", "7")),
              HasSubstr("no claims"));
}

TEST_F(JwtTest, RefusesAnotherKeysSignature) {
  EXPECT_THAT(ErrorOf(MakeToken(JwtAlgorithm::kRs256, MakeRsaPrivateKey(), "r",
                                kClaims)),
              HasSubstr("signature"));
  EXPECT_THAT(ErrorOf(MakeToken(JwtAlgorithm::kEs256, MakeEcPrivateKey(), "e",
                                kClaims)),
              HasSubstr("signature"));
  EXPECT_THAT(ErrorOf(MakeToken(JwtAlgorithm::kEdDsa, MakeEd25519PrivateKey(),
                                "d", kClaims)),
              HasSubstr("signature"));
  EXPECT_THAT(
      ErrorOf(MakeToken(JwtAlgorithm::kRs256, *rsa_, "unknown", kClaims)),
      HasSubstr("no known key"));
}

TEST_F(JwtTest, RefusesClaimsThatWereChanged) {
  for (const std::string& token :
       {MakeToken(JwtAlgorithm::kRs256, *rsa_, "r", kClaims),
        MakeToken(JwtAlgorithm::kEs256, *ec_, "e", kClaims),
        MakeToken(JwtAlgorithm::kEdDsa, *ed_, "d", kClaims),
        MakeToken(JwtAlgorithm::kHs256, secret_, "h", kClaims)}) {
    std::vector<std::string> parts = absl::StrSplit(token, '.');
    parts[1] = EncodeBase64Url(R"({"sub":"robot-8"})");
    EXPECT_THAT(ErrorOf(absl::StrCat(parts[0], ".", parts[1], ".", parts[2])),
                HasSubstr("signature"));
  }
}

TEST_F(JwtTest, RefusesASecondTextForOneToken) {
  const std::string token =
      MakeToken(JwtAlgorithm::kRs256, *rsa_, "r", kClaims);
  ASSERT_EQ(ErrorOf(token), "OK");
  EXPECT_NE(ErrorOf(token + "="), "OK");
  EXPECT_NE(ErrorOf(token + "\n"), "OK");
  EXPECT_NE(ErrorOf(" " + token), "OK");
  EXPECT_NE(ErrorOf(token + "." + token), "OK");
  EXPECT_NE(ErrorOf(token + std::string(1, '\0')), "OK");
}

TEST_F(JwtTest, RefusesHeadersThatItCannotHonour) {
  for (const char* header :
       {R"({"alg":"HS256","kid":"h","crit":["b64"],"b64":false})",
        R"({"alg":"HS256","kid":7})", R"({"kid":"h"})", R"({"alg":["HS256"]})",
        R"("HS256")", "not json"}) {
    EXPECT_NE(ErrorOf(MakeHmacToken(header, kClaims, secret_)), "OK") << header;
  }
  EXPECT_EQ(
      ErrorOf(MakeHmacToken(R"({"alg":"HS256","kid":"h"})", kClaims, secret_)),
      "OK");
}

TEST_F(JwtTest, RefusesClaimsThatAreNoObject) {
  for (const char* claims : {"[]", "7", "{", "\"a\""}) {
    EXPECT_NE(
        ErrorOf(MakeHmacToken(R"({"alg":"HS256","kid":"h"})", claims, secret_)),
        "OK")
        << claims;
  }
}

TEST_F(JwtTest, RefusesLongTokensUnread) {
  EXPECT_THAT(ErrorOf(std::string(kLongestToken + 1, 'a')),
              HasSubstr("longer than 8192 bytes"));
}

}  // namespace
}  // namespace treeline::access

#include "server/access/token_claims.h"

#include <string>

#include "common/base/error_info.h"
#include "gtest/gtest.h"

namespace treeline::access {
namespace {

constexpr int64_t kNow = 1'800'000'000;

std::string ReasonFor(const std::string& json, const ClaimRules& rules = {},
                      int64_t now = kNow) {
  const auto claims = ParseTokenClaims(json, rules, now);
  if (claims.ok()) return "OK";
  EXPECT_EQ(claims.status().code(), absl::StatusCode::kUnauthenticated);
  return base::ErrorInfoOf(claims.status()).reason;
}

// Claims that are fine but for `more`, which may say a member again: the last
// one counts.
std::string Claims(const std::string& more) {
  return R"({"sub":"robot-7","aud":"treeline","exp":1800000100)" +
         (more.empty() ? "" : "," + more) + "}";
}

TEST(TokenClaims, AreReadWhole) {
  const auto claims = ParseTokenClaims(
      Claims(R"("scope":"localize","rate":12.5,"iat":1799999990)"), {}, kNow);
  ASSERT_TRUE(claims.ok()) << claims.status();
  EXPECT_EQ(claims->subject, "robot-7");
  EXPECT_TRUE(claims->may_localize);
  EXPECT_FALSE(claims->may_administer);
  EXPECT_EQ(claims->rate_per_s, 12.5);
  EXPECT_EQ(claims->expires_unix_s, 1800000100);
}

TEST(TokenClaims, ExpireWithLeeway) {
  EXPECT_EQ(ReasonFor(Claims(""), {}, 1800000129), "OK");
  EXPECT_EQ(ReasonFor(Claims(""), {}, 1800000130), "TOKEN_EXPIRED");
  EXPECT_EQ(ReasonFor(Claims(""), {.leeway_s = 0}, 1800000099), "OK");
  EXPECT_EQ(ReasonFor(Claims(""), {.leeway_s = 0}, 1800000100),
            "TOKEN_EXPIRED");
}

TEST(TokenClaims, MustExpire) {
  EXPECT_EQ(ReasonFor(R"({"sub":"a","aud":"treeline"})"), "TOKEN_INVALID");
  for (const char* exp : {"null", "\"1800000100\"", "true", "[]", "1e300"}) {
    EXPECT_EQ(ReasonFor(Claims(std::string("\"exp\":") + exp)),
              "TOKEN_INVALID");
  }
  EXPECT_EQ(ReasonFor(Claims("\"exp\":1800000100.5")), "OK");
}

TEST(TokenClaims, DoNotHoldBeforeTheirTime) {
  EXPECT_EQ(ReasonFor(Claims("\"nbf\":1800000030")), "OK");
  EXPECT_EQ(ReasonFor(Claims("\"nbf\":1800000031")), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims("\"iat\":1800000030")), "OK");
  EXPECT_EQ(ReasonFor(Claims("\"iat\":1800000031")), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims("\"nbf\":\"soon\"")), "TOKEN_INVALID");
}

TEST(TokenClaims, AreForUs) {
  EXPECT_EQ(ReasonFor(Claims(R"("aud":["other","treeline"])")), "OK");
  EXPECT_EQ(ReasonFor(Claims(R"("aud":["other"])")), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims(R"("aud":"other")")), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims(R"("aud":7)")), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(R"({"sub":"a","exp":1800000100})"), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims(R"("aud":"maps")"), {.audience = "maps"}), "OK");
}

TEST(TokenClaims, AreOfTheIssuerThatIsNamed) {
  const ClaimRules rules = {.issuer = "https://id.example"};
  EXPECT_EQ(ReasonFor(Claims(R"("iss":"https://id.example")"), rules), "OK");
  EXPECT_EQ(ReasonFor(Claims(R"("iss":"https://else")"), rules),
            "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims(""), rules), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims(R"("iss":"https://else")")), "OK");
}

TEST(TokenClaims, OfStrangersAreInvalidEvenWhenExpired) {
  EXPECT_EQ(ReasonFor(Claims(R"("aud":"other","exp":1)")), "TOKEN_INVALID");
}

TEST(TokenClaims, NameAClient) {
  EXPECT_EQ(ReasonFor(R"({"aud":"treeline","exp":1800000100})"),
            "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims(R"("sub":"")")), "TOKEN_INVALID");
  EXPECT_EQ(ReasonFor(Claims(R"("sub":7)")), "TOKEN_INVALID");
  const std::string longest(256, 'x');
  EXPECT_EQ(ReasonFor(Claims("\"sub\":\"" + longest + "\"")), "OK");
  EXPECT_EQ(ReasonFor(Claims("\"sub\":\"" + longest + "x\"")), "TOKEN_INVALID");
}

TEST(TokenClaims, RefuseARateThatIsNone) {
  for (const char* rate : {"0", "-1", "\"5\"", "null"}) {
    EXPECT_EQ(ReasonFor(Claims(std::string("\"rate\":") + rate)),
              "TOKEN_INVALID");
  }
}

struct ScopesCase {
  const char* claim;
  bool localize;
  bool admin;
  bool inspect = false;
};

TEST(TokenClaims, HoldScopesInEveryUsualForm) {
  const ScopesCase cases[] = {
      {R"("scope":"localize")", true, false},
      {R"("scope":"openid admin localize")", true, true},
      {R"("scp":["localize"])", true, false},
      {R"("scp":["admin",7,null])", false, true},
      {R"("scp":"localize admin")", true, true},
      {R"("scope":"localize","scp":["admin"])", true, true},
      {R"("scope":"administrator localize2 LOCALIZE")", false, false},
      {R"("scope":"localize,admin,inspect")", false, false},
      {R"("scope":"inspect")", false, false, true},
      {R"("scp":["localize","inspect"])", true, false, true},
      {R"("scope":{"admin":true})", false, false},
      {R"("roles":["admin"])", false, false},
  };
  for (const ScopesCase& expected : cases) {
    const auto claims = ParseTokenClaims(Claims(expected.claim), {}, kNow);
    ASSERT_TRUE(claims.ok()) << expected.claim;
    EXPECT_EQ(claims->may_localize, expected.localize) << expected.claim;
    EXPECT_EQ(claims->may_administer, expected.admin) << expected.claim;
    EXPECT_EQ(claims->may_inspect, expected.inspect) << expected.claim;
  }
}

TEST(TokenClaims, RefuseWhatIsNoObject) {
  for (const char* json : {"", "null", "[]", "{", "\"text\"", "{}x"}) {
    EXPECT_EQ(ReasonFor(json), "TOKEN_INVALID") << json;
  }
}

TEST(ClaimRules, NeedAnAudienceAndASmallLeeway) {
  EXPECT_TRUE(ClaimRules{}.Validate().ok());
  EXPECT_FALSE(ClaimRules{.audience = ""}.Validate().ok());
  EXPECT_FALSE(ClaimRules{.leeway_s = -1}.Validate().ok());
  EXPECT_FALSE(ClaimRules{.leeway_s = 301}.Validate().ok());
}

}  // namespace
}  // namespace treeline::access

#include "server/access/token_verifier.h"

#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "gtest/gtest.h"
#include "server/access/fake_clocks.h"
#include "server/access/jwt.h"
#include "server/access/token_maker.h"

namespace treeline::access {
namespace {

constexpr int64_t kNow = 1'800'000'000;

class TokenVerifierTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "/verifier-" +
            testing::UnitTest::GetInstance()->current_test_info()->name();
    PutKeys({EcJwk(ec_, "e")});
    auto store = KeyStore::Open({.path = path_}, clock_, nullptr);
    ASSERT_TRUE(store.ok()) << store.status();
    keys_ = *std::move(store);
  }
  void TearDown() override { std::filesystem::remove(path_); }

  void PutKeys(const std::vector<std::string>& keys) {
    ASSERT_TRUE(base::WriteFileAtomically(path_, Jwks(keys)).ok());
  }

  std::string Token(const std::string& subject, int64_t lifetime_s = 100) {
    return MakeToken(
        JwtAlgorithm::kEs256, ec_, "e",
        absl::StrCat(R"({"aud":"treeline","scope":"localize","sub":")", subject,
                     R"(","exp":)", kNow + lifetime_s, "}"));
  }

  static std::string ReasonOf(const absl::StatusOr<TokenClaims>& claims) {
    return claims.ok() ? "OK" : base::ErrorInfoOf(claims.status()).reason;
  }

  const std::string ec_ = MakeEcPrivateKey();
  std::string path_;
  FakeClock clock_;
  FakeWallClock wall_{kNow};
  std::unique_ptr<KeyStore> keys_;
};

TEST_F(TokenVerifierTest, ChecksASignatureOnce) {
  TokenVerifier verifier({}, *keys_, wall_);
  const std::string token = Token("robot-7");
  for (int i = 0; i < 5; ++i) {
    const auto claims = verifier.Verify(token);
    ASSERT_TRUE(claims.ok()) << claims.status();
    EXPECT_EQ(claims->subject, "robot-7");
  }
  EXPECT_EQ(verifier.signatures_checked(), 1);
}

TEST_F(TokenVerifierTest, LetsWhatItRemembersExpireInTime) {
  TokenVerifier verifier({}, *keys_, wall_);
  const std::string token = Token("robot-7");
  EXPECT_EQ(ReasonOf(verifier.Verify(token)), "OK");
  wall_.Set(kNow + 129);
  EXPECT_EQ(ReasonOf(verifier.Verify(token)), "OK");
  wall_.Set(kNow + 130);
  EXPECT_EQ(ReasonOf(verifier.Verify(token)), "TOKEN_EXPIRED");
}

TEST_F(TokenVerifierTest, ForgetsEverythingWhenTheKeysChange) {
  TokenVerifier verifier({}, *keys_, wall_);
  const std::string token = Token("robot-7");
  EXPECT_EQ(ReasonOf(verifier.Verify(token)), "OK");
  PutKeys({EcJwk(MakeEcPrivateKey(), "e")});
  clock_.Advance(std::chrono::seconds(1));
  EXPECT_EQ(ReasonOf(verifier.Verify(token)), "TOKEN_INVALID");
  PutKeys({});
  clock_.Advance(std::chrono::seconds(1));
  EXPECT_EQ(ReasonOf(verifier.Verify(token)), "TOKEN_INVALID");
  PutKeys({EcJwk(ec_, "e")});
  clock_.Advance(std::chrono::seconds(1));
  EXPECT_EQ(ReasonOf(verifier.Verify(token)), "OK");
}

TEST_F(TokenVerifierTest, RemembersABoundedNumberAndForgetsTheOldest) {
  TokenVerifier verifier({.cache_size = 2}, *keys_, wall_);
  const std::string a = Token("a");
  const std::string b = Token("b");
  const std::string c = Token("c");
  for (const std::string& token : {a, b, a, c}) {
    EXPECT_EQ(ReasonOf(verifier.Verify(token)), "OK");
  }
  EXPECT_EQ(verifier.signatures_checked(), 3);
  EXPECT_EQ(ReasonOf(verifier.Verify(a)), "OK");  // used after b
  EXPECT_EQ(verifier.signatures_checked(), 3);
  EXPECT_EQ(ReasonOf(verifier.Verify(b)), "OK");
  EXPECT_EQ(verifier.signatures_checked(), 4);
}

TEST_F(TokenVerifierTest, RemembersABoundedNumberOfForgedTokensApart) {
  TokenVerifier verifier({.cache_size = 20}, *keys_, wall_);
  const std::string good = Token("robot-7");
  EXPECT_EQ(ReasonOf(verifier.Verify(good)), "OK");
  const std::string stem = good.substr(0, good.rfind('.') + 1);
  const std::string forged = stem + std::string(86, 'A');
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(ReasonOf(verifier.Verify(forged)), "TOKEN_INVALID");
  }
  EXPECT_EQ(verifier.signatures_checked(), 2);
  for (const char c : {'B', 'C', 'D'}) {
    EXPECT_EQ(ReasonOf(verifier.Verify(stem + c + std::string(85, 'A'))),
              "TOKEN_INVALID");
  }
  EXPECT_EQ(verifier.signatures_checked(), 5);
  EXPECT_EQ(ReasonOf(verifier.Verify(forged)), "TOKEN_INVALID");  // forgotten
  EXPECT_EQ(verifier.signatures_checked(), 6);
  EXPECT_EQ(ReasonOf(verifier.Verify(good)), "OK");  // not pushed out
  EXPECT_EQ(verifier.signatures_checked(), 6);
}

TEST_F(TokenVerifierTest, DoesNotHoldATokensEarlinessAgainstIt) {
  TokenVerifier verifier({}, *keys_, wall_);
  const std::string early =
      MakeToken(JwtAlgorithm::kEs256, ec_, "e",
                absl::StrCat(R"({"aud":"treeline","sub":"a","exp":)",
                             kNow + 1000, R"(,"nbf":)", kNow + 100, "}"));
  EXPECT_EQ(ReasonOf(verifier.Verify(early)), "TOKEN_INVALID");
  wall_.Set(kNow + 100);
  EXPECT_EQ(ReasonOf(verifier.Verify(early)), "OK");
}

TEST_F(TokenVerifierTest, RefusesLongTokensBeforeAnythingElse) {
  TokenVerifier verifier({}, *keys_, wall_);
  EXPECT_EQ(ReasonOf(verifier.Verify(std::string(kLongestToken + 1, 'a'))),
            "TOKEN_INVALID");
  EXPECT_EQ(verifier.signatures_checked(), 0);
}

TEST_F(TokenVerifierTest, AnswersManyThreadsWhileKeysChange) {
  TokenVerifier verifier({.cache_size = 3}, *keys_, wall_);
  std::vector<std::string> tokens;
  for (int i = 0; i < 6; ++i) tokens.push_back(Token(absl::StrCat(i)));
  const std::string key = EcJwk(ec_, "e");
  const std::string other = EcJwk(MakeEcPrivateKey(), "other");
  std::vector<std::thread> threads;
  for (size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (size_t i = 0; i < 60; ++i) {
        const size_t k = (i + t) % tokens.size();
        const auto claims = verifier.Verify(tokens[k]);
        ASSERT_TRUE(claims.ok()) << claims.status();
        EXPECT_EQ(claims->subject, absl::StrCat(k));
      }
    });
  }
  for (int i = 0; i < 10; ++i) {
    PutKeys(i % 2 == 0 ? std::vector<std::string>{key, other}
                       : std::vector<std::string>{key});
    clock_.Advance(std::chrono::seconds(1));
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace treeline::access

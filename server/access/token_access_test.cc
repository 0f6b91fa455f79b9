#include "server/access/token_access.h"

#include <filesystem>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "gtest/gtest.h"
#include "server/access/fake_clocks.h"
#include "server/access/token_maker.h"

namespace treeline::access {
namespace {

class TokenAccessTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "/access-" +
            testing::UnitTest::GetInstance()->current_test_info()->name();
    ASSERT_TRUE(base::WriteFileAtomically(path_, Jwks({EcJwk(ec_, "e")})).ok());
    auto store = KeyStore::Open({.path = path_}, clock_, nullptr);
    ASSERT_TRUE(store.ok()) << store.status();
    keys_ = *std::move(store);
    verifier_ =
        std::make_unique<TokenVerifier>(TokenVerifierOptions{}, *keys_, wall_);
  }
  void TearDown() override { std::filesystem::remove(path_); }

  service::CallInfo WithScope(const std::string& scope,
                              bool admin_listener = false,
                              const std::string& more = "") {
    service::CallInfo call = {.peer = "ipv4:10.0.0.7:1",
                              .admin_listener = admin_listener};
    call.credentials.bearer_token = MakeToken(
        JwtAlgorithm::kEs256, ec_, "e",
        absl::StrCat(R"({"aud":"treeline","sub":"robot-7","exp":200,"scope":")",
                     scope, "\"", more, "}"));
    return call;
  }

  static service::CallInfo WithCertificate(
      const std::vector<std::string>& names, bool admin_listener = false) {
    service::CallInfo call = {.admin_listener = admin_listener};
    call.credentials.certificate_names = names;
    return call;
  }

  // The client's id, or the reason why there is none.
  static std::string Answer(service::AccessPolicy& access,
                            const service::CallInfo& call,
                            service::Scope scope) {
    const auto client = access.Admit(call, scope);
    if (client.ok()) return client->id;
    const std::string reason = base::ErrorInfoOf(client.status()).reason;
    const bool denied =
        reason == "SCOPE_MISSING" || reason == "ADMIN_LISTENER_ONLY";
    EXPECT_EQ(client.status().code(), denied
                                          ? absl::StatusCode::kPermissionDenied
                                          : absl::StatusCode::kUnauthenticated);
    return reason;
  }

  const std::string ec_ = MakeEcPrivateKey();
  std::string path_;
  FakeClock clock_;
  FakeWallClock wall_{100};
  std::unique_ptr<KeyStore> keys_;
  std::unique_ptr<TokenVerifier> verifier_;
};

TEST_F(TokenAccessTest, AsksForTheScopeOfTheCall) {
  TokenAccess access({}, verifier_.get());
  EXPECT_EQ(Answer(access, WithScope("localize"), service::Scope::kLocalize),
            "robot-7");
  EXPECT_EQ(Answer(access, WithScope("admin"), service::Scope::kLocalize),
            "SCOPE_MISSING");
  EXPECT_EQ(Answer(access, WithScope("admin", true), service::Scope::kAdmin),
            "robot-7");
  EXPECT_EQ(Answer(access, WithScope("inspect"), service::Scope::kInspect),
            "robot-7");
  EXPECT_EQ(
      Answer(access, WithScope("localize admin"), service::Scope::kInspect),
      "SCOPE_MISSING");
  EXPECT_EQ(Answer(access, WithScope("inspect"), service::Scope::kLocalize),
            "SCOPE_MISSING");
  EXPECT_EQ(Answer(access, WithScope("localize", true), service::Scope::kAdmin),
            "SCOPE_MISSING");
}

TEST_F(TokenAccessTest, TellsMissingInvalidAndExpiredTokensApart) {
  TokenAccess access({}, verifier_.get());
  EXPECT_EQ(Answer(access, {}, service::Scope::kLocalize), "TOKEN_MISSING");
  service::CallInfo call;
  call.credentials.bearer_token = "nonsense";
  EXPECT_EQ(Answer(access, call, service::Scope::kLocalize), "TOKEN_INVALID");
  const service::CallInfo good = WithScope("localize");
  wall_.Set(230);
  EXPECT_EQ(Answer(access, good, service::Scope::kLocalize), "TOKEN_EXPIRED");
}

TEST_F(TokenAccessTest,
       LetsOperatorsInThroughTheirListenerUnlessToldOtherwise) {
  TokenAccess access({}, verifier_.get());
  EXPECT_EQ(Answer(access, WithScope("admin"), service::Scope::kAdmin),
            "ADMIN_LISTENER_ONLY");
  EXPECT_EQ(Answer(access, {.admin_listener = true}, service::Scope::kAdmin),
            "TOKEN_MISSING");
  TokenAccess both({.admin_on_public_listener = true}, verifier_.get());
  EXPECT_EQ(Answer(both, WithScope("admin"), service::Scope::kAdmin),
            "robot-7");
  EXPECT_EQ(Answer(both, WithScope("localize"), service::Scope::kAdmin),
            "SCOPE_MISSING");
  EXPECT_EQ(Answer(both, {}, service::Scope::kAdmin), "TOKEN_MISSING");
}

TEST_F(TokenAccessTest, CanTrustWhoeverReachesTheAdminListener) {
  TokenAccess access({.open_admin_listener = true}, verifier_.get());
  const service::CallInfo call = {.peer = "ipv4:127.0.0.1:5",
                                  .admin_listener = true};
  EXPECT_EQ(Answer(access, call, service::Scope::kAdmin), "ipv4:127.0.0.1");
  EXPECT_EQ(Answer(access, call, service::Scope::kLocalize), "TOKEN_MISSING");
  EXPECT_EQ(Answer(access, {}, service::Scope::kAdmin), "ADMIN_LISTENER_ONLY");
}

TEST_F(TokenAccessTest, PassesTheTokensRateOn) {
  TokenAccess access({}, verifier_.get());
  const auto client = access.Admit(WithScope("localize", false, ",\"rate\":5"),
                                   service::Scope::kLocalize);
  ASSERT_TRUE(client.ok());
  EXPECT_EQ(client->max_rate_per_s, 5);
}

TEST_F(TokenAccessTest, KnowsCertificatesByName) {
  TokenAccess access(
      {.certificate_scopes = {{"robot.example", {service::Scope::kLocalize}},
                              {"spiffe://example/ops",
                               {service::Scope::kAdmin,
                                service::Scope::kLocalize}}}},
      nullptr);
  EXPECT_EQ(Answer(access, WithCertificate({"x", "robot.example"}),
                   service::Scope::kLocalize),
            "robot.example");
  EXPECT_EQ(Answer(access, WithCertificate({"robot.example"}, true),
                   service::Scope::kAdmin),
            "SCOPE_MISSING");
  EXPECT_EQ(Answer(access, WithCertificate({"spiffe://example/ops"}, true),
                   service::Scope::kAdmin),
            "spiffe://example/ops");
  EXPECT_EQ(Answer(access, WithCertificate({"stranger.example"}),
                   service::Scope::kLocalize),
            "TOKEN_MISSING");
  EXPECT_EQ(Answer(access, WithCertificate({}), service::Scope::kLocalize),
            "TOKEN_MISSING");
}

TEST_F(TokenAccessTest, CanTrustEveryCertificate) {
  TokenAccess access({.certificate_scopes = {{"*", {service::Scope::kLocalize}},
                                             {"banned.example", {}}}},
                     nullptr);
  EXPECT_EQ(Answer(access, WithCertificate({"any"}), service::Scope::kLocalize),
            "any");
  EXPECT_EQ(Answer(access, WithCertificate({"any", "banned.example"}),
                   service::Scope::kLocalize),
            "SCOPE_MISSING");
  EXPECT_EQ(Answer(access, WithCertificate({}), service::Scope::kLocalize),
            "TOKEN_MISSING");
}

TEST_F(TokenAccessTest, JudgesByTheTokenWhereThereIsOne) {
  TokenAccess access(
      {.certificate_scopes = {{"*", {service::Scope::kLocalize}}}},
      verifier_.get());
  service::CallInfo call = WithScope("admin");
  call.credentials.certificate_names = {"robot.example"};
  EXPECT_EQ(Answer(access, call, service::Scope::kLocalize), "SCOPE_MISSING");
  call.credentials.bearer_token = "nonsense";
  EXPECT_EQ(Answer(access, call, service::Scope::kLocalize), "TOKEN_INVALID");
  TokenAccess without(
      {.certificate_scopes = {{"*", {service::Scope::kLocalize}}}}, nullptr);
  EXPECT_EQ(Answer(without, call, service::Scope::kLocalize), "TOKEN_INVALID");
}

}  // namespace
}  // namespace treeline::access

#include "server/access/rate_limited_access.h"

#include <chrono>
#include <string>

#include "common/base/error_info.h"
#include "gtest/gtest.h"
#include "server/access/fake_clocks.h"

namespace treeline::access {
namespace {

using std::chrono::milliseconds;

class FakeAccess final : public service::AccessPolicy {
 public:
  absl::StatusOr<service::Client> Admit(const service::CallInfo& /*call*/,
                                        service::Scope /*scope*/) override {
    return answer;
  }
  absl::StatusOr<service::Client> answer = service::Client{.id = "robot-7"};
};

class RateLimitedAccessTest : public testing::Test {
 protected:
  // Calls that are let in before one is not, up to 1000.
  int Admitted(service::AccessPolicy& access,
               service::Scope scope = service::Scope::kLocalize) {
    int admitted = 0;
    while (admitted < 1000 && access.Admit({}, scope).ok()) ++admitted;
    return admitted;
  }

  FakeClock clock_;
  FakeAccess inner_;
};

TEST_F(RateLimitedAccessTest, SaysWhoItIsWithoutCounting) {
  RateLimitedAccess access(inner_, {.rate_per_s = 3, .burst = 2}, clock_);
  for (int i = 0; i < 10; ++i) {
    const auto client = access.Identify({}, service::Scope::kLocalize);
    ASSERT_TRUE(client.ok());
    EXPECT_EQ(client->id, "robot-7");
  }
  EXPECT_EQ(Admitted(access), 2);
}

TEST_F(RateLimitedAccessTest, RefusesWithReasonAndTheTimeToTryAgain) {
  RateLimitedAccess access(inner_, {.rate_per_s = 3, .burst = 2}, clock_);
  EXPECT_EQ(Admitted(access), 2);
  const absl::Status refused =
      access.Admit({}, service::Scope::kLocalize).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(base::ErrorInfoOf(refused).reason, "RATE_LIMITED");
  // A third of a second, rounded up, so that it is not too early.
  ASSERT_EQ(base::RetryAfterOf(refused), milliseconds(334));
  clock_.Advance(milliseconds(334));
  EXPECT_EQ(Admitted(access), 1);
}

TEST_F(RateLimitedAccessTest, CountsClientsAndAddressesApart) {
  RateLimitedAccess access(inner_, {.rate_per_s = 1, .burst = 2}, clock_);
  EXPECT_EQ(Admitted(access), 2);
  inner_.answer = service::Client{.id = "ipv4:10.0.0.7"};
  EXPECT_EQ(Admitted(access), 2);
  inner_.answer = service::Client{.id = "ipv4:10.0.0.8"};
  EXPECT_EQ(Admitted(access), 2);
}

TEST_F(RateLimitedAccessTest, CountsTheAddressesOfOneIpv6NetworkTogether) {
  RateLimitedAccess access(inner_, {.rate_per_s = 1, .burst = 2}, clock_);
  inner_.answer = service::Client{.id = "ipv6:%5B2001:db8::1%5D"};
  EXPECT_EQ(Admitted(access), 2);
  inner_.answer = service::Client{.id = "ipv6:%5B2001:db8::ffff:2%5D"};
  EXPECT_EQ(Admitted(access), 0);
  inner_.answer = service::Client{.id = "ipv6:[2001:db8:0:1::1]"};
  EXPECT_EQ(Admitted(access), 2);
}

TEST(RateKeyOf, KeepsTheIpv4AddressesOfADualStackListenerApart) {
  EXPECT_NE(RateKeyOf("ipv6:%5B::ffff:10.0.0.7%5D"),
            RateKeyOf("ipv6:%5B::ffff:10.0.0.8%5D"));
  EXPECT_EQ(RateKeyOf("ipv6:%5Bfe80::1%25eth0%5D"),
            RateKeyOf("ipv6:%5Bfe80::2%25eth0%5D"));
  EXPECT_EQ(RateKeyOf("ipv6:nonsense"), "ipv6:nonsense");
  EXPECT_EQ(RateKeyOf("robot-7"), "robot-7");
}

TEST_F(RateLimitedAccessTest, LetsOperatorsIn) {
  RateLimitedAccess access(inner_, {.rate_per_s = 1, .burst = 2}, clock_);
  EXPECT_EQ(Admitted(access, service::Scope::kAdmin), 1000);
  EXPECT_EQ(Admitted(access), 2);
}

TEST_F(RateLimitedAccessTest, WithoutARateLimitsNobodyWhoseTokenSaysNothing) {
  RateLimitedAccess access(inner_, {.rate_per_s = 0}, clock_);
  EXPECT_EQ(Admitted(access), 1000);
  inner_.answer->max_rate_per_s = 7;
  EXPECT_EQ(Admitted(access), 7);
}

TEST_F(RateLimitedAccessTest, TakesTheLesserOfTheTokensRateAndItsOwn) {
  RateLimitedAccess access(inner_, {.rate_per_s = 100, .burst = 50}, clock_);
  inner_.answer = service::Client{.id = "slow", .max_rate_per_s = 10};
  EXPECT_EQ(Admitted(access), 5);
  clock_.Advance(milliseconds(100));
  EXPECT_EQ(Admitted(access), 1);
  inner_.answer = service::Client{.id = "greedy", .max_rate_per_s = 1e9};
  EXPECT_EQ(Admitted(access), 50);
  inner_.answer = service::Client{.id = "slowest", .max_rate_per_s = 0.5};
  EXPECT_EQ(Admitted(access), 1);
}

TEST_F(RateLimitedAccessTest, PassesOnWhatTheOtherPolicyRefuses) {
  RateLimitedAccess access(inner_, {.rate_per_s = 1}, clock_);
  inner_.answer =
      base::WithReason(absl::UnauthenticatedError("no"), "TOKEN_MISSING");
  EXPECT_EQ(access.Admit({}, service::Scope::kLocalize).status(),
            inner_.answer.status());
}

TEST(RateLimitOptions, NameWhatIsOutOfRange) {
  EXPECT_TRUE(RateLimitOptions{}.Validate().ok());
  EXPECT_TRUE(RateLimitOptions{.rate_per_s = 0.001}.Validate().ok());
  EXPECT_FALSE(RateLimitOptions{.rate_per_s = -1}.Validate().ok());
  EXPECT_FALSE(RateLimitOptions{.rate_per_s = 1e7}.Validate().ok());
  EXPECT_FALSE(RateLimitOptions{.burst = 0}.Validate().ok());
  EXPECT_FALSE(RateLimitOptions{.max_clients = 0}.Validate().ok());
}

}  // namespace
}  // namespace treeline::access

#include "common/flood_guard/flood_guard.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <chrono>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/socket_address.h"

namespace treeline::flood_guard {
namespace {

using ::testing::HasSubstr;

class FakeClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now; }
  base::MonotonicTime now = base::MonotonicTime() + std::chrono::hours(1);
};

class FloodGuardTest : public ::testing::Test {
 protected:
  bool Calls(const std::string& address, int64_t calls, int64_t frames = 0) {
    return guard_.Draw(address, address + ":1",
                       {.calls = calls, .frames = frames});
  }
  void Pass(double seconds) {
    clock_.now += std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(seconds));
  }

  FakeClock clock_;
  std::vector<std::string> reports_;
  FloodGuard guard_{
      {.calls_per_s = 100, .open_calls = 200, .connections = 3},
      clock_,
      [this](const std::string& text) { reports_.push_back(text); }};
};

// 2 * 200 calls of all addresses together.
TEST_F(FloodGuardTest, ManyAddressesShareWhatTwoMayHaveOpen) {
  const auto open = [this](const std::string& address, int calls) {
    if (!Calls(address, calls)) return false;
    for (int i = 0; i < calls; ++i) guard_.BeginCall(address);
    return true;
  };
  for (const char* address : {"a", "b", "c", "d"}) {
    EXPECT_TRUE(open(address, 100)) << address;
    Pass(2);
  }
  // A fifth of 400, but no more than 80.
  EXPECT_FALSE(open("e", 81));
  EXPECT_EQ(guard_.cuts(CutReason::kOpenCalls), 1u);
  EXPECT_TRUE(open("e", 80));
  EXPECT_FALSE(open("a", 1));
  for (int i = 0; i < 100; ++i) guard_.EndCall("a");
  for (int i = 0; i < 100; ++i) guard_.EndCall("b");
  Pass(2);
  EXPECT_TRUE(open("f", 100));
}

// The service need not have heard of calls that began a moment ago; and whoever
// has few is let in, however many others have.
TEST_F(FloodGuardTest, CallsCountForAllFromTheirBeginning) {
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(Calls(std::string(1, static_cast<char>('a' + i)), 100));
  }
  EXPECT_FALSE(Calls("e", 81));
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(Calls("f" + std::to_string(i), 16));
  }
  EXPECT_FALSE(Calls("g", 17));
  Pass(1);
  EXPECT_TRUE(Calls("h", 100));
}

TEST_F(FloodGuardTest, ASecondsWorthOfCallsMayComeAtOnce) {
  EXPECT_TRUE(Calls("a", 40));
  EXPECT_TRUE(Calls("a", 60));
  EXPECT_FALSE(Calls("a", 1));
  EXPECT_EQ(guard_.cuts(CutReason::kCalls), 1u);
  Pass(0.1);
  EXPECT_TRUE(Calls("a", 10));
  EXPECT_FALSE(Calls("a", 1));
}

// 90 calls a second for ever, each with all the frames that it may have.
TEST_F(FloodGuardTest, WhoStaysBelowItsLimitsIsNeverCut) {
  for (int i = 0; i < 10000; ++i) {
    ASSERT_TRUE(Calls("a", 9, 90));
    Pass(0.1);
  }
}

TEST(FloodGuard, NoMoreBeginAtOnceThanMayBeOpen) {
  const FakeClock clock;
  FloodGuard guard({.calls_per_s = 1e6, .open_calls = 100}, clock);
  EXPECT_TRUE(guard.Draw("a", "a:1", {.calls = 100}));
  EXPECT_FALSE(guard.Draw("a", "a:1", {.calls = 1}));
  EXPECT_EQ(guard.cuts(CutReason::kCalls), 1u);
}

// 1000 calls a second where 100 are allowed, each with its picture.
TEST_F(FloodGuardTest, PayloadPaysForCalls) {
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(guard_.Draw("a", "a:1", {.calls = 1}));
    ASSERT_TRUE(guard_.Draw("a", "a:1", {.payload_bytes = 20000}));
    Pass(0.001);
  }
  // But nothing is saved up.
  ASSERT_TRUE(guard_.Draw("a", "a:1", {.payload_bytes = 1 << 30}));
  EXPECT_TRUE(Calls("a", 100));
  EXPECT_FALSE(Calls("a", 1));
}

TEST_F(FloodGuardTest, FramesHaveALimitOfTheirOwn) {
  EXPECT_TRUE(Calls("a", 0, 1000));
  EXPECT_FALSE(Calls("a", 0, 1));
  EXPECT_EQ(guard_.cuts(CutReason::kFrames), 1u);
  EXPECT_TRUE(Calls("a", 10));
}

TEST_F(FloodGuardTest, OneAddressDoesNotPayForAnother) {
  EXPECT_FALSE(Calls("a", 1000));
  EXPECT_TRUE(Calls("b", 10));
  EXPECT_TRUE(guard_.Open("b", "b:1"));
}

TEST_F(FloodGuardTest, WhoIsCutComesBackAfterASecond) {
  ASSERT_TRUE(guard_.Open("a", "a:1"));
  EXPECT_FALSE(Calls("a", 1000));
  guard_.Close("a");
  Pass(0.99);
  EXPECT_FALSE(guard_.Open("a", "a:2"));
  EXPECT_EQ(guard_.cuts(CutReason::kCameBack), 1u);
  Pass(0.02);
  EXPECT_TRUE(guard_.Open("a", "a:3"));
}

// The connections that an address already has may be those of others behind
// the same router.
TEST_F(FloodGuardTest, AfterACutOtherConnectionsOfTheAddressGoOn) {
  EXPECT_FALSE(Calls("a", 1000));
  EXPECT_TRUE(Calls("a", 1));
}

TEST_F(FloodGuardTest, ConnectionsCountWhileTheyLive) {
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(guard_.Open("a", "a:1"));
  EXPECT_FALSE(guard_.Open("a", "a:4"));
  EXPECT_EQ(guard_.cuts(CutReason::kConnections), 1u);
  guard_.Close("a");
  EXPECT_TRUE(guard_.Open("a", "a:5"));
}

TEST_F(FloodGuardTest, ConnectionsCostCalls) {
  int opened = 0;
  while (guard_.Open("a", "a:1")) {
    guard_.Close("a");
    ++opened;
  }
  EXPECT_EQ(opened, 75 / kCallsOfAConnection);
  // Those that are there may go on.
  EXPECT_TRUE(Calls("a", 20));
}

TEST_F(FloodGuardTest, OpenCallsAreLimitedHoweverSlowlyTheyCome) {
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(Calls("a", 1));
    guard_.BeginCall("a");
    Pass(60);
  }
  EXPECT_FALSE(Calls("a", 1));
  EXPECT_EQ(guard_.cuts(CutReason::kOpenCalls), 1u);
  // Frames of the calls that are there may come.
  EXPECT_TRUE(Calls("a", 0, 1));
  guard_.EndCall("a");
  EXPECT_TRUE(Calls("a", 1));
}

TEST_F(FloodGuardTest, AddressesThatAreAsGoodAsNewAreForgotten) {
  ASSERT_TRUE(guard_.Open("open", "open:1"));
  guard_.BeginCall("busy");
  for (int i = 0; i < 100000; ++i) {
    Calls(std::to_string(i), 1);
    Pass(0.01);
  }
  EXPECT_LT(guard_.addresses(), 4096u);
  // Those that are not are remembered.
  EXPECT_TRUE(guard_.Open("open", "open:2"));
  EXPECT_TRUE(guard_.Open("open", "open:3"));
  EXPECT_FALSE(guard_.Open("open", "open:4"));
}

TEST_F(FloodGuardTest, SaysWhoAndWhyOnceASecond) {
  for (int i = 0; i < 5; ++i) Calls("a", 1000);
  ASSERT_EQ(reports_.size(), 1u);
  EXPECT_EQ(reports_[0],
            "cut off a:1: its address begins more than 100 calls a second, "
            "connections included");
  Pass(1);
  Calls("a", 0, 1000000);
  ASSERT_EQ(reports_.size(), 2u);
  EXPECT_THAT(reports_[1], HasSubstr("1000 frames a second"));
  EXPECT_THAT(reports_[1], HasSubstr("and 4 connections"));
  Pass(1);
  guard_.StopReporting();
  Calls("a", 1000);
  EXPECT_EQ(reports_.size(), 2u);
}

TEST(FloodLimits, AreChecked) {
  EXPECT_TRUE(FloodLimits().Validate().ok());
  EXPECT_FALSE(FloodLimits{.calls_per_s = 0}.Validate().ok());
  EXPECT_FALSE(FloodLimits{.open_calls = 9}.Validate().ok());
  EXPECT_FALSE(FloodLimits{.connections = 0}.Validate().ok());
}

std::string KeyOf(int family, const char* text) {
  sockaddr_storage address = {};
  address.ss_family = static_cast<sa_family_t>(family);
  inet_pton(family, text,
            family == AF_INET
                ? static_cast<void*>(
                      &reinterpret_cast<sockaddr_in&>(address).sin_addr)
                : &reinterpret_cast<sockaddr_in6&>(address).sin6_addr);
  return base::AddressKey(address);
}

TEST(AddressKeyOfPeer, IsTheSameFromTheSocketAndFromGrpc) {
  EXPECT_EQ(KeyOf(AF_INET, "192.0.2.1"),
            AddressKeyOfPeer("ipv4:192.0.2.1:4711"));
  EXPECT_EQ(KeyOf(AF_INET6, "2001:db8:1:2:3::4"),
            AddressKeyOfPeer("ipv6:%5B2001:db8:1:2::9%5D:1"));
  EXPECT_NE(KeyOf(AF_INET6, "2001:db8:1:3::4"),
            AddressKeyOfPeer("ipv6:[2001:db8:1:2::9]:1"));
  EXPECT_EQ(KeyOf(AF_INET6, "fe80::1"),
            AddressKeyOfPeer("ipv6:%5Bfe80::1%25eth0%5D:1"));
  EXPECT_EQ(KeyOf(AF_INET6, "::ffff:192.0.2.1"),
            AddressKeyOfPeer("ipv4:192.0.2.1:4711"));
  EXPECT_EQ(AddressKeyOfPeer("unix:/tmp/socket"), "");
  EXPECT_EQ(AddressKeyOfPeer("ipv4:nowhere:1"), "");
  EXPECT_EQ(AddressKeyOfPeer(""), "");
}

}  // namespace
}  // namespace treeline::flood_guard

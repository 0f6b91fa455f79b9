#include "common/flood_guard/watched_connection.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "common/base/clock.h"
#include "common/flood_guard/testing_frames.h"

namespace treeline::flood_guard {
namespace {

using Verdict = WatchedConnection::Verdict;

class WatchedConnectionTest : public ::testing::Test {
 protected:
  std::shared_ptr<WatchedConnection> Open() {
    return WatchedConnection::Open(guard_, "a", "a:1");
  }

  const base::SteadyClock clock_{};
  const std::shared_ptr<FloodGuard> guard_ = std::make_shared<FloodGuard>(
      FloodLimits{.calls_per_s = 1000, .connections = 2}, clock_);
};

std::string Calls(int count) {
  std::string frames;
  for (int i = 0; i < count; ++i) {
    frames += TestFrame(kTestHeaders, kTestEndHeaders, 2 * i + 1, "block");
  }
  return frames;
}

// The first bytes of a ClientHello in a record that says it is this long.
std::string Hello(int record_bytes, const std::string& random) {
  return std::string("\x16\x03\x01") + static_cast<char>(record_bytes >> 8) +
         static_cast<char>(record_bytes) +
         std::string("\x01\0\x01\xfc\x03\x03", 6) + random;
}

const std::string& kRandom = *new std::string(32, 'r');

TEST_F(WatchedConnectionTest, IsOneOfItsAddressForAsLongAsItLives) {
  auto first = Open();
  const auto second = Open();
  EXPECT_EQ(Open(), nullptr);
  first.reset();
  EXPECT_NE(Open(), nullptr);
}

TEST_F(WatchedConnectionTest, HttpIsCountedFromTheFirstByte) {
  const auto watched = Open();
  EXPECT_EQ(watched->Receive(kTestPreface +
                             TestFrame(kTestSettings, kTestAck, 0, "")),
            Verdict::kGoOn);
  EXPECT_EQ(watched->Receive(Calls(10)), Verdict::kGoOn);
  EXPECT_EQ(watched->Receive(Calls(100000)), Verdict::kCut);
  // And for good.
  EXPECT_EQ(watched->Receive("x"), Verdict::kCut);
  EXPECT_EQ(guard_->cuts(CutReason::kCalls), 1u);
}

TEST_F(WatchedConnectionTest, HeadersWithoutEndCutWhateverTheRate) {
  const auto watched = Open();
  EXPECT_EQ(watched->Receive(kTestPreface + TestFrame(kTestHeaders, 0, 1,
                                                      std::string(70000, 'h'))),
            Verdict::kCut);
  EXPECT_EQ(guard_->cuts(CutReason::kHeaderBlock), 1u);
}

TEST_F(WatchedConnectionTest, TlsIsCountedWhenItIsDecrypted) {
  const auto watched = Open();
  const std::string hello = Hello(508, kRandom);
  EXPECT_EQ(watched->Receive(hello.substr(0, 7)), Verdict::kGoOn);
  EXPECT_EQ(watched->client_random(), "");
  EXPECT_EQ(watched->Receive(hello.substr(7) + "the rest"),
            Verdict::kTlsBegins);
  EXPECT_EQ(watched->client_random(), kRandom);
  EXPECT_EQ(watched->Receive(kTestPreface + Calls(100000)), Verdict::kGoOn);
  EXPECT_TRUE(watched->Decrypted(kTestPreface + Calls(10)));
  EXPECT_FALSE(watched->Decrypted(Calls(100000)));
  EXPECT_FALSE(watched->Decrypted("x"));
  EXPECT_EQ(watched->Receive("x"), Verdict::kCut);
}

TEST_F(WatchedConnectionTest, ARecordThatEndsInTheHelloIsCut) {
  EXPECT_EQ(Open()->Receive(Hello(37, kRandom)), Verdict::kCut);
  EXPECT_EQ(guard_->cuts(CutReason::kHandshake), 1u);
}

TEST_F(WatchedConnectionTest, AHandshakeThatDoesNotBeginWithAHelloIsCut) {
  std::string other = Hello(508, kRandom);
  other[5] = 2;
  EXPECT_EQ(Open()->Receive(other), Verdict::kCut);
  EXPECT_EQ(guard_->cuts(CutReason::kHandshake), 1u);
}

}  // namespace
}  // namespace treeline::flood_guard

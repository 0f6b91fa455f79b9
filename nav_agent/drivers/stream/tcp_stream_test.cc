#include "nav_agent/drivers/stream/tcp_stream.h"

#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/stream/descriptor_stream.h"
#include "nav_agent/drivers/stream/testing_streams.h"

namespace treeline::stream {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSoon(10'000);

struct Connection {
  std::unique_ptr<ByteStream> device;
  std::unique_ptr<ByteStream> host;
};

Connection Connect() {
  const auto listener = TcpListener::Listen(0);
  EXPECT_TRUE(listener.ok()) << listener.status();
  auto host =
      ConnectTcp({.host = "127.0.0.1", .port = (*listener)->port()}, {});
  EXPECT_TRUE(host.ok()) << host.status();
  auto device = (*listener)->Accept(kSoon, {});
  EXPECT_TRUE(device.ok()) << device.status();
  return {*std::move(device), *std::move(host)};
}

TEST(TcpStreamTest, CarriesBytesBothWays) {
  const Connection connection = Connect();
  ASSERT_NE(connection.device, nullptr);
  ASSERT_TRUE(connection.host->Write(AsBytes("BM\n"), kSoon).ok());
  EXPECT_EQ(ReadExactly(*connection.device, 3), "BM\n");
  ASSERT_TRUE(connection.device->Write(AsBytes("BM\n00P\n\n"), kSoon).ok());
  EXPECT_EQ(ReadExactly(*connection.host, 8), "BM\n00P\n\n");
}

TEST(TcpStreamTest, WritesMoreThanTheSystemTakesAtOnce) {
  const Connection connection = Connect();
  std::string much;
  much.resize(20'000'000, 'x');
  std::string received;
  {
    const std::jthread reader(
        [&] { received = ReadExactly(*connection.device, much.size()); });
    EXPECT_TRUE(connection.host->Write(AsBytes(much), kSoon).ok());
  }
  EXPECT_EQ(received.size(), much.size());
}

TEST(TcpStreamTest, SaysThatTheOtherSideClosed) {
  Connection connection = Connect();
  connection.device.reset();
  std::vector<uint8_t> buffer(16);
  EXPECT_EQ(connection.host->Read(buffer, kSoon, {}).status().code(),
            absl::StatusCode::kUnavailable);
  // The first write after that may still fit into the buffer.
  absl::Status status;
  for (int i = 0; i < 1000 && status.ok(); ++i) {
    status = connection.host->Write(AsBytes(std::string(100'000, 'x')), kSoon);
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
}

TEST(TcpStreamTest, AStopEndsTheWait) {
  const Connection connection = Connect();
  size_t count = 99;
  {
    std::jthread reader([&](const std::stop_token& stop) {
      std::vector<uint8_t> buffer(16);
      const auto read =
          connection.host->Read(buffer, std::chrono::hours(1), stop);
      count = read.ok() ? *read : 98;
    });
  }
  EXPECT_EQ(count, 0u);
}

TEST(TcpStreamTest, SaysThatNobodyListens) {
  // A port that was free a moment ago.
  int port = 0;
  {
    const auto listener = TcpListener::Listen(0);
    ASSERT_TRUE(listener.ok());
    port = (*listener)->port();
  }
  TcpOpener opener({.host = "127.0.0.1", .port = port});
  const auto stream = opener.Open({});
  EXPECT_EQ(stream.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(stream.status().message()),
              testing::HasSubstr("refused"));
}

TEST(TcpStreamTest, StopsBeforeItConnects) {
  std::stop_source source;
  source.request_stop();
  TcpOpener opener({.host = "127.0.0.1", .port = 9});
  EXPECT_EQ(opener.Open(source.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

TEST(TcpListenerTest, ReturnsNothingWhenNobodyCalls) {
  const auto listener = TcpListener::Listen(0);
  ASSERT_TRUE(listener.ok());
  const auto stream = (*listener)->Accept(milliseconds(1), {});
  ASSERT_TRUE(stream.ok());
  EXPECT_EQ(*stream, nullptr);
}

TEST(TcpListenerTest, RefusesAPortThatIsTaken) {
  const auto listener = TcpListener::Listen(0);
  ASSERT_TRUE(listener.ok());
  EXPECT_EQ(TcpListener::Listen((*listener)->port()).status().code(),
            absl::StatusCode::kUnavailable);
}

TEST(StreamPairTest, IsConnectedWithItself) {
  auto pair = MakeStreamPair();
  ASSERT_TRUE(pair.ok());
  ASSERT_TRUE(pair->first->Write(AsBytes("hello"), kSoon).ok());
  EXPECT_EQ(ReadExactly(*pair->second, 5), "hello");
}

TEST(StopRequestedWithinTest, TellsAStopFromTheEndOfTheWait) {
  std::stop_source source;
  EXPECT_FALSE(
      StopRequestedWithin(std::chrono::nanoseconds(1), source.get_token()));
  source.request_stop();
  EXPECT_TRUE(StopRequestedWithin(std::chrono::hours(1), source.get_token()));
}

}  // namespace
}  // namespace treeline::stream

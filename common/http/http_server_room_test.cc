// Who makes room where all connections are taken.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "common/http/testing_http_server.h"

namespace treeline::http {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

using HttpServerRoom = HttpServerTest;

// No time passes.
class StandingClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override {
    return base::MonotonicTime(std::chrono::hours(1));
  }
};

TEST_F(HttpServerRoom, SlowRequestsMakeRoomForNewOnes) {
  options_.max_connections = 2;
  Start();
  const RawClient slow_body(server_->address());
  slow_body.Send("POST / HTTP/1.1\r\nContent-Length: 1000000\r\n\r\nx");
  const RawClient slow_head(server_->address());
  slow_head.Send("GET / HTTP/1.1\r\nX: ");
  // A second passes until it is known that they are slow.
  std::string answer;
  while (!absl::StartsWith(answer, "HTTP/1.1 200")) {
    answer = Exchange("GET / HTTP/1.1\r\nConnection: close\r\n\r\n");
  }
  EXPECT_EQ(handler_.handled, 1);
}

TEST_F(HttpServerRoom, ProbesAreAnsweredWhereAllConnectionsAreBusy) {
  options_.max_connections = 1;
  options_.max_probe_connections = 1;
  Start();
  const RawClient busy(server_->address());
  busy.Send("GET /wait HTTP/1.1\r\nConnection: close\r\n\r\n");
  handler_.waiting.WaitForNotification();
  // Says nothing, and so makes room for who does.
  const RawClient silent(server_->address());
  for (int i = 0; i < 3; ++i) {
    std::string answer;
    while (!absl::StartsWith(answer, "HTTP/1.1 200")) {
      answer = Exchange("GET /probe HTTP/1.1\r\n\r\n");
    }
  }
  std::string answer;
  while (answer.empty()) answer = Exchange("GET / HTTP/1.1\r\n\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 503"));
  handler_.go_on.Notify();
  EXPECT_THAT(busy.ReadAll(), StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpServerRoom, OneClientDoesNotGetAllConnections) {
  options_.max_connections = 100;
  options_.max_connections_per_client = 1;
  Start();
  const RawClient busy(server_->address());
  busy.Send("GET /wait HTTP/1.1\r\nConnection: close\r\n\r\n");
  handler_.waiting.WaitForNotification();
  EXPECT_THAT(RawClient(server_->address()).ReadAll(),
              StartsWith("HTTP/1.1 503"));
  handler_.go_on.Notify();
  EXPECT_THAT(busy.ReadAll(), StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpServerRoom, TheAddressWithMostConnectionsMakesRoom) {
  options_.max_connections = 3;
  options_.stream.min_body_bytes_per_s = 1;
  Start();
  std::vector<std::unique_ptr<RawClient>> crowd;
  for (int i = 1; i <= 3; ++i) {
    crowd.push_back(
        std::make_unique<RawClient>(server_->address(), "127.0.0.2"));
    crowd.back()->Send("POST / HTTP/1.1\r\nContent-Length: 999999\r\n\r\n" +
                       std::string(100000, 'x'));
    while (handler_.admitted < i) std::this_thread::yield();
  }
  EXPECT_THAT(RawClient(server_->address(), "127.0.0.2").ReadAll(),
              StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(Exchange("GET / HTTP/1.1\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpServerRoom, ClientsThatDoNotReadMakeRoom) {
  options_.max_connections = 2;
  Start();
  const RawClient first(server_->address(), "127.0.0.2");
  const RawClient second(server_->address(), "127.0.0.2");
  first.Send("GET /large HTTP/1.1\r\n\r\n");
  second.Send("GET /large HTTP/1.1\r\n\r\n");
  EXPECT_THAT(first.ReadSome(), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(second.ReadSome(), StartsWith("HTTP/1.1 200"));
  // Some time passes until the system takes no more for them.
  std::string answer;
  while (!absl::StartsWith(answer, "HTTP/1.1 200")) {
    answer = Exchange("GET / HTTP/1.1\r\nConnection: close\r\n\r\n");
  }
  EXPECT_EQ(handler_.handled, 3);
}

TEST_F(HttpServerRoom, WhoComesInCrowdsDoesNotPushOutOthers) {
  options_.max_connections = 2;
  const StandingClock clock;
  auto server = HttpServer::Start(options_, handler_, clock);
  ASSERT_TRUE(server.ok()) << server.status();
  const RawClient honest((*server)->address());
  const RawClient first((*server)->address(), "127.0.0.2");
  const RawClient second((*server)->address(), "127.0.0.2");
  // Of the same age, and it has said as little.
  EXPECT_THAT(first.ReadAll(), IsEmpty());
  honest.Send("GET / HTTP/1.1\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(honest.ReadAll(), StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpServerRoom, IdleConnectionsMakeRoomForNewOnes) {
  options_.max_connections = 1;
  Start();
  const RawClient first(server_->address());
  first.Send("GET / HTTP/1.1\r\n\r\n");
  ASSERT_THAT(first.ReadSome(), StartsWith("HTTP/1.1 200"));
  // A thread that has just answered may not be idle yet.
  std::string answer;
  while (!absl::StartsWith(answer, "HTTP/1.1 200")) {
    const RawClient second(server_->address());
    second.Send("GET / HTTP/1.1\r\n\r\n");
    answer = second.ReadSome();
  }
  EXPECT_THAT(first.ReadAll(), IsEmpty());
}

TEST_F(HttpServerRoom, IsBusyWhenAllConnectionsAre) {
  options_.max_connections = 1;
  Start();
  const RawClient busy(server_->address());
  busy.Send("GET /wait HTTP/1.1\r\nConnection: close\r\n\r\n");
  handler_.waiting.WaitForNotification();
  const std::string answer = RawClient(server_->address()).ReadAll();
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(answer, HasSubstr("Retry-After: 1"));
  handler_.go_on.Notify();
  EXPECT_THAT(busy.ReadAll(), StartsWith("HTTP/1.1 200"));
}

}  // namespace
}  // namespace treeline::http

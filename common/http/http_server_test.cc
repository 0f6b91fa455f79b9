#include "common/http/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/notification.h"
#include "common/base/byte_budget.h"
#include "common/http/testing_http_server.h"

namespace treeline::http {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

TEST_F(HttpServerTest, KeepsConnectionsAlive) {
  Start();
  const RawClient client(server_->address());
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(client.Send(
        "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\n\r\nhi"));
    std::string answer;
    while (!answer.ends_with("hi")) {
      const std::string more = client.ReadSome();
      ASSERT_FALSE(more.empty()) << "closed after " << i;
      answer += more;
    }
    ASSERT_THAT(answer, StartsWith("HTTP/1.1 200"));
  }
}

TEST_F(HttpServerTest, AnswersPipelinedRequestsInOrder) {
  Start();
  const std::string answers = Exchange(
      "POST / HTTP/1.1\r\nContent-Length: 3\r\n\r\none"
      "POST / HTTP/1.1\r\nConnection: close\r\nContent-Length: 3\r\n\r\ntwo");
  const size_t one = answers.find("\r\n\r\none");
  ASSERT_NE(one, std::string::npos);
  EXPECT_NE(answers.find("\r\n\r\ntwo", one), std::string::npos);
}

TEST_F(HttpServerTest, StreamsInChunksAndCloses) {
  Start();
  const std::string answer = Exchange("GET /stream HTTP/1.1\r\n\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(answer, HasSubstr("X-Common: yes\r\n"));
  EXPECT_THAT(answer, HasSubstr("\r\n\r\n7\r\npart 0\n\r\n7\r\npart 1\n\r\n"
                                "7\r\npart 2\n\r\n0\r\n\r\n"));
}

TEST_F(HttpServerTest, APostIsAnsweredByAStreamAfterItsBody) {
  Start();
  const std::string answer = Exchange(
      "POST /stream HTTP/1.1\r\nContent-Length: 2\r\n\r\nhi"
      "GET / HTTP/1.1\r\n\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n"));
  // It ends the connection: what came after it is not answered.
  EXPECT_TRUE(answer.ends_with("part 2\n\r\n0\r\n\r\n")) << answer;
}

TEST_F(HttpServerTest, AStreamEndsWithItsReader) {
  handler_.endless = true;
  Start();
  {
    const RawClient client(server_->address());
    ASSERT_TRUE(client.Send("GET /stream HTTP/1.1\r\n\r\n"));
    ASSERT_THAT(client.ReadSome(), StartsWith("HTTP/1.1 200"));
  }
  handler_.streamed.WaitForNotification();
}

TEST_F(HttpServerTest, AStreamEndsWhenItsReaderDoesNotRead) {
  handler_.endless = true;
  options_.stream.write_timeout = std::chrono::milliseconds(100);
  Start();
  const RawClient client(server_->address());
  ASSERT_TRUE(client.Send("GET /stream HTTP/1.1\r\n\r\n"));
  handler_.streamed.WaitForNotification();
}

TEST_F(HttpServerTest, TakesChunkedAndCompressedBodies) {
  Start();
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nConnection: close\r\n"
                       "Transfer-Encoding: chunked\r\n\r\n"
                       "3\r\nabc\r\n2\r\nde\r\n0\r\n\r\n"),
              HasSubstr("\r\n\r\nabcde"));
  httplib::Client client("http://" + server_->address());
  client.set_compress(true);
  const std::string body(100000, 'x');
  const auto result = client.Post("/", body, "text/plain");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->body, body);
}

TEST_F(HttpServerTest, ABodyThatGrowsBeyondTheLimitIsRefused) {
  Start();
  httplib::Client client("http://" + server_->address());
  client.set_compress(true);
  const std::string bomb(8 << 20, '\0');
  const auto result = client.Post("/", bomb, "text/plain");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 413);
  EXPECT_EQ(handler_.handled, 0);
}

TEST_F(HttpServerTest, ABodyThatIsTooLargeIsRefusedBeforeItIsSent) {
  Start();
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nContent-Length: 1048577\r\n\r\n"),
              StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nExpect: 100-continue\r\n"
                       "Content-Length: 1048577\r\n\r\n"),
              StartsWith("HTTP/1.1 413"));
}

TEST_F(HttpServerTest, ARefusalReachesAClientThatIsStillSending) {
  Start();
  httplib::Client client("http://" + server_->address());
  const auto result =
      client.Post("/", std::string(20 << 20, 'x'), "text/plain");
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->status, 413);
}

TEST_F(HttpServerTest, ContinuesWhereClientsAsk) {
  Start();
  const RawClient client(server_->address());
  client.Send(
      "POST / HTTP/1.1\r\nExpect: 100-continue\r\nConnection: close\r\n"
      "Content-Length: 2\r\n\r\n");
  EXPECT_THAT(client.ReadSome(), StartsWith("HTTP/1.1 100"));
  client.Send("ok");
  EXPECT_THAT(client.ReadAll(), HasSubstr("\r\n\r\nok"));
}

TEST_F(HttpServerTest, HeadersThatAreTooLargeAreRefused) {
  Start();
  std::string request = "GET / HTTP/1.1\r\n";
  while (request.size() < options_.stream.head_bytes + 100) {
    absl::StrAppend(&request, "A", request.size(), ": ", std::string(1000, 'x'),
                    "\r\n");
  }
  EXPECT_THAT(Exchange(request + "\r\n"), StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(Exchange(std::string(100000, 'x')), StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(Exchange("GET /" + std::string(9000, 'x') + " HTTP/1.1\r\n\r\n"),
              StartsWith("HTTP/1.1 414"));
}

TEST_F(HttpServerTest, NonsenseIsRefused) {
  Start();
  EXPECT_THAT(Exchange("nonsense\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\n\r\n"), StartsWith("HTTP/1.1 411"));
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"),
              StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nContent-Length: 1\r\n"
                       "Content-Length: 2\r\n\r\nab"),
              StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nContent-Length: 1\r\n"
                       "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
              StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nContent-Length: 1\r\n"
                       "Content-Encoding: zstd\r\n\r\nx"),
              StartsWith("HTTP/1.1 415"));
  EXPECT_EQ(handler_.handled, 0);
}

// What a proxy in front of the server may read in another way.
TEST_F(HttpServerTest, WhatOthersReadInAnotherWayIsRefused) {
  Start();
  for (const char* headers :
       {"Content-Length: +2\r\n", "Content-Length: 2, 2\r\n",
        "Content-Length : 2\r\n", "Transfer-Encoding : chunked\r\n",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
        "Transfer-Encoding: %63hunked\r\n", "X: 1\r\n Content-Length: 2\r\n",
        "X: 1\nContent-Length: 2\r\n", "X: \x01\r\n"}) {
    EXPECT_THAT(
        Exchange(absl::StrCat("POST / HTTP/1.1\r\n", headers, "\r\n0\r\n\r\n")),
        StartsWith("HTTP/1.1 400"))
        << headers;
  }
  EXPECT_THAT(
      Exchange(absl::string_view("GET / HTTP/1.1\r\nX: \0\r\n\r\n", 25)),
      StartsWith("HTTP/1.1 400"));
  for (const char* chunk : {"+2", "0x2", "2 2", "-1"}) {
    EXPECT_THAT(Exchange(absl::StrCat("POST / HTTP/1.1\r\nTransfer-Encoding: "
                                      "chunked\r\n\r\n",
                                      chunk, "\r\nhi\r\n0\r\n\r\n")),
                StartsWith("HTTP/1.1 400"))
        << chunk;
  }
  EXPECT_EQ(handler_.handled, 0);
}

TEST_F(HttpServerTest, WhoIsNotLetInNeedNotSendTheBody) {
  Start();
  const std::string head = " HTTP/1.1\r\nContent-Length: 100000\r\n";
  EXPECT_THAT(Exchange("POST /denied" + head + "\r\n"),
              StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(Exchange("POST /denied" + head + "Expect: 100-continue\r\n\r\n"),
              StartsWith("HTTP/1.1 401"));
  EXPECT_EQ(handler_.admitted, 2);
  EXPECT_EQ(handler_.handled, 0);
}

TEST_F(HttpServerTest, IsAskedOnceWhoIsLetInAndRemembersIt) {
  Start();
  const RawClient client(server_->address());
  client.Send(
      "POST /client HTTP/1.1\r\nExpect: 100-continue\r\n"
      "Connection: close\r\nContent-Length: 2\r\n\r\n");
  EXPECT_THAT(client.ReadSome(), StartsWith("HTTP/1.1 100"));
  client.Send("ok");
  EXPECT_THAT(client.ReadAll(), HasSubstr("\r\n\r\nrobot-7"));
  EXPECT_EQ(handler_.admitted, 1);
}

TEST_F(HttpServerTest, BodiesForWhichThereIsNoMemoryAreRefused) {
  base::ByteBudget budget(100000);
  base::ByteLease others(&budget);
  ASSERT_TRUE(others.Resize(99000));
  options_.budget = &budget;
  Start();
  const std::string answer =
      Exchange("POST / HTTP/1.1\r\nContent-Length: 5000\r\n\r\n" +
               std::string(5000, 'x'));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(answer, HasSubstr("Retry-After: 1"));
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nConnection: close\r\n"
                       "Content-Length: 500\r\n\r\n" +
                       std::string(500, 'x')),
              StartsWith("HTTP/1.1 200"));
  others.Release();
  server_.reset();
  EXPECT_EQ(budget.used_bytes(), 0u);
}

TEST_F(HttpServerTest, ErrorsHaveTheCommonHeaders) {
  Start();
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\n\r\n"), HasSubstr("X-Common: yes"));
  EXPECT_THAT(Exchange("nonsense\r\n\r\n"), HasSubstr("X-Common: yes"));
}

TEST_F(HttpServerTest, AFaultOfTheHandlerIs500AndServingGoesOn) {
  Start();
  const std::string answer = Exchange("GET /throw HTTP/1.1\r\n\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 500"));
  EXPECT_THAT(answer, Not(HasSubstr("bad_alloc")));
  EXPECT_THAT(Exchange("GET / HTTP/1.1\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpServerTest, AnUnreadBodyIsNotTakenForARequest) {
  Start();
  const std::string answer = Exchange(
      "POST /early HTTP/1.1\r\nContent-Length: 30\r\n\r\n"
      "GET /smuggled HTTP/1.1\r\n\r\n1234");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 404"));
  EXPECT_EQ(handler_.handled, 0);
  EXPECT_EQ(answer.find("HTTP/1.1", 1), std::string::npos);
}

// The deadline is for the whole head: a byte at a time does not extend it.
TEST_F(HttpServerTest, ASlowHeadIsEndedInTime) {
  options_.stream.head_timeout = std::chrono::milliseconds(100);
  Start();
  const RawClient client(server_->address());
  client.Send("GET / HTTP/1.1\r\nX-Slow: ");
  std::string answer;
  std::thread reader([&] { answer = client.ReadAll(); });
  // Ends when the server has closed: it would never for ever trickling bytes.
  while (client.Send("x")) std::this_thread::yield();
  reader.join();
  EXPECT_TRUE(answer.empty() || answer.starts_with("HTTP/1.1 408") ||
              answer.starts_with("HTTP/1.1 431"))
      << answer;
  EXPECT_EQ(handler_.handled, 0);
}

TEST_F(HttpServerTest, AHeadThatNeverEndsIsATimeout) {
  options_.stream.head_timeout = std::chrono::milliseconds(50);
  Start();
  EXPECT_THAT(Exchange("GET / HTTP/1.1\r\nX-Slow: "),
              StartsWith("HTTP/1.1 408"));
  EXPECT_THAT(Exchange("GET"), StartsWith("HTTP/1.1 408"));
}

TEST_F(HttpServerTest, ABodyThatNeverEndsIsATimeout) {
  options_.stream.body_timeout = std::chrono::milliseconds(50);
  Start();
  EXPECT_THAT(Exchange("POST / HTTP/1.1\r\nContent-Length: 100\r\n\r\nabc"),
              StartsWith("HTTP/1.1 408"));
}

TEST_F(HttpServerTest, ABodyThatTricklesIsATimeout) {
  options_.stream.body_rate_grace = std::chrono::milliseconds(50);
  options_.stream.min_body_bytes_per_s = 1 << 20;
  options_.max_body_mib = 32;
  Start();
  const RawClient client(server_->address());
  client.Send("POST / HTTP/1.1\r\nContent-Length: 30000000\r\n\r\n");
  std::string answer;
  std::thread reader([&] { answer = client.ReadAll(); });
  // Ends when the server has closed, long before all has come.
  while (client.Send("x")) std::this_thread::yield();
  reader.join();
  EXPECT_TRUE(answer.empty() || answer.starts_with("HTTP/1.1 408")) << answer;
  EXPECT_EQ(handler_.handled, 0);
}

// Not slow, but all of one address: 0 B/s would do.
TEST_F(HttpServerTest, LargeAnswersForWhichThereIsNoMemoryAreRefused) {
  base::ByteBudget answers(100000);
  base::ByteLease others(&answers);
  ASSERT_TRUE(others.Resize(99000));
  options_.answers = &answers;
  Start();
  const auto echo = [this](size_t size) {
    return Exchange(absl::StrCat(
        "POST / HTTP/1.1\r\nConnection: close\r\nContent-Length: ", size,
        "\r\n\r\n", std::string(size, 'x')));
  };
  const std::string answer = echo(20000);
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(answer, HasSubstr("Retry-After: 1"));
  EXPECT_THAT(echo(16384), StartsWith("HTTP/1.1 200"));
  others.Release();
  EXPECT_THAT(echo(20000), StartsWith("HTTP/1.1 200"));
  server_.reset();
  EXPECT_EQ(answers.used_bytes(), 0u);
}

TEST_F(HttpServerTest, IdleConnectionsAreClosed) {
  options_.idle_timeout = std::chrono::milliseconds(20);
  Start();
  EXPECT_THAT(Exchange("GET / HTTP/1.1\r\n\r\n"), StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpServerTest, StopLetsARequestInFlightFinish) {
  Start();
  const RawClient client(server_->address());
  client.Send("GET /wait HTTP/1.1\r\n\r\n");
  handler_.waiting.WaitForNotification();
  std::thread stopper([this] { server_->Stop(std::chrono::hours(1)); });
  // Refused from now on, some time.
  httplib::Client other("http://" + server_->address());
  while (other.Get("/")) std::this_thread::yield();
  handler_.go_on.Notify();
  EXPECT_THAT(client.ReadAll(), StartsWith("HTTP/1.1 200"));
  stopper.join();
}

TEST_F(HttpServerTest, StopDoesNotWaitForIdleConnections) {
  Start();
  const RawClient client(server_->address());
  client.Send("GET / HTTP/1.1\r\n\r\n");
  ASSERT_THAT(client.ReadSome(), StartsWith("HTTP/1.1 200"));
  const RawClient silent(server_->address());
  server_->Stop(std::chrono::hours(1));
  EXPECT_THAT(client.ReadAll(), IsEmpty());
  EXPECT_THAT(silent.ReadAll(), IsEmpty());
}

TEST_F(HttpServerTest, StopEndsRequestsThatNeverArriveAfterTheGrace) {
  Start();
  const RawClient client(server_->address());
  client.Send(
      "POST / HTTP/1.1\r\nExpect: 100-continue\r\n"
      "Content-Length: 100\r\n\r\n");
  ASSERT_THAT(client.ReadSome(), StartsWith("HTTP/1.1 100"));
  server_->Stop(std::chrono::milliseconds(10));
  EXPECT_EQ(handler_.handled, 0);
}

TEST_F(HttpServerTest, SaysWhyAnAddressCannotBeBound) {
  Start();
  options_.listen = server_->address();
  const auto second = HttpServer::Start(options_, handler_, clock_);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("Address already in use"));
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr(options_.listen));
}

TEST_F(HttpServerTest, ListensOnIpv6) {
  options_.listen = "[::1]:0";
  const auto server = HttpServer::Start(options_, handler_, clock_);
  if (!server.ok()) GTEST_SKIP() << "no IPv6 here: " << server.status();
  EXPECT_THAT((*server)->address(), StartsWith("[::1]:"));
}

TEST_F(HttpServerTest, ManyClientsAtATime) {
  Start();
  std::vector<std::thread> clients;
  std::atomic<int> right = 0;
  for (int c = 0; c < 16; ++c) {
    clients.emplace_back([&, c] {
      httplib::Client client("http://" + server_->address());
      client.set_keep_alive(true);
      client.set_tcp_nodelay(true);
      for (int i = 0; i < 50; ++i) {
        const std::string body = absl::StrCat(c, ":", i);
        const auto result = client.Post("/", body, "text/plain");
        if (result && result->body == body) ++right;
      }
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(right, 16 * 50);
}

}  // namespace
}  // namespace treeline::http

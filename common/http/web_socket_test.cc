#include "common/http/web_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/http/http_server.h"
#include "common/http/testing_web_socket.h"

namespace treeline::http {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using Event = WebSocketReader::Event;

constexpr size_t kMaxBytes = 1000;

HttpRequest Handshake() {
  return {.method = "GET",
          .headers = {{"upgrade", "websocket"},
                      {"connection", "keep-alive, Upgrade"},
                      {"sec-websocket-key", "dGhlIHNhbXBsZSBub25jZQ=="},
                      {"sec-websocket-version", "13"}}};
}

// Events of bytes that come `step` at a time; messages and pings as text.
std::vector<std::string> EventsOf(absl::string_view bytes, size_t step,
                                  size_t room = 1 << 20) {
  WebSocketReader reader(kMaxBytes,
                         [room](size_t wanted) { return wanted <= room; });
  std::vector<std::string> events;
  while (!bytes.empty()) {
    absl::string_view piece = bytes.substr(0, step);
    bytes.remove_prefix(piece.size());
    while (!piece.empty()) {
      switch (reader.Read(piece)) {
        case Event::kNone:
          break;
        case Event::kMessage:
          events.push_back((reader.is_text() ? "text " : "binary ") +
                           reader.TakeMessage());
          break;
        case Event::kPing:
          events.push_back("ping " + reader.ping());
          break;
        case Event::kClose:
          events.push_back("close");
          break;
        case Event::kFailed:
          events.push_back(std::to_string(static_cast<int>(reader.failure())));
          return events;
      }
    }
  }
  return events;
}

// The example of RFC 6455, 1.3.
TEST(WebSocketTest, AnswersTheHandshakeOfTheStandard) {
  const auto response = AcceptWebSocket(Handshake(), "");
  ASSERT_TRUE(response.has_value());
  EXPECT_EQ(response->status, 101);
  EXPECT_THAT(response->headers,
              ElementsAre(Pair("Upgrade", "websocket"),
                          Pair("Sec-WebSocket-Accept",
                               "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=")));
  const auto with_protocol = AcceptWebSocket(Handshake(), "chat");
  EXPECT_THAT(with_protocol->headers,
              testing::Contains(Pair("Sec-WebSocket-Protocol", "chat")));
}

TEST(WebSocketTest, RefusesOtherHandshakes) {
  const auto refuses = [](const std::string& header, const std::string& value) {
    HttpRequest request = Handshake();
    request.headers[header] = value;
    return !AcceptWebSocket(request, "").has_value();
  };
  EXPECT_TRUE(refuses("sec-websocket-version", "8"));
  EXPECT_TRUE(refuses("sec-websocket-version", ""));
  EXPECT_TRUE(refuses("sec-websocket-key", ""));
  EXPECT_TRUE(refuses("sec-websocket-key", "c2hvcnQ="));
  EXPECT_TRUE(refuses("sec-websocket-key", "***"));
  EXPECT_TRUE(refuses("upgrade", "h2c"));
  EXPECT_TRUE(refuses("connection", "keep-alive"));
  HttpRequest post = Handshake();
  post.method = "POST";
  EXPECT_FALSE(AcceptWebSocket(post, "").has_value());
}

TEST(WebSocketTest, ListsProtocols) {
  HttpRequest request = Handshake();
  EXPECT_THAT(WebSocketProtocols(request), IsEmpty());
  request.headers["sec-websocket-protocol"] = " a , b,,c ";
  EXPECT_THAT(WebSocketProtocols(request), ElementsAre("a", "b", "c"));
}

TEST(WebSocketTest, ReadsMessagesHoweverTheyArrive) {
  const std::string bytes =
      TestFrame(kTestText, "hello") + TestFrame(kTestBinary, "") +
      TestFrame(kTestBinary, std::string(200, 'x')) +
      // Fragments, with a ping and a pong between them.
      TestFrame(kTestText, "a", false) + TestFrame(kTestPing, "p") +
      TestFrame(0, "", false) + TestFrame(kTestPong, "") +
      TestFrame(0, "b", true) + TestFrame(kTestClose, "");
  for (const size_t step : {size_t{1}, size_t{3}, size_t{7}, bytes.size()}) {
    EXPECT_THAT(
        EventsOf(bytes, step),
        ElementsAre("text hello", "binary ", "binary " + std::string(200, 'x'),
                    "ping p", "text ab", "close"))
        << step;
  }
}

TEST(WebSocketTest, KnowsWhetherAMessageHasBegun) {
  WebSocketReader reader(kMaxBytes, [](size_t) { return true; });
  EXPECT_FALSE(reader.is_amid());
  const std::string frame = TestFrame(kTestBinary, "hello");
  for (size_t i = 0; i < frame.size(); ++i) {
    absl::string_view piece(frame.data() + i, 1);
    const Event event = reader.Read(piece);
    EXPECT_EQ(event == Event::kMessage, i + 1 == frame.size());
    EXPECT_EQ(reader.is_amid(), i + 1 < frame.size()) << i;
  }
}

TEST(WebSocketTest, RefusesWhatTheStandardDoes) {
  const std::string protocol_error = "1002";
  const auto last = [](absl::string_view bytes) {
    const auto events = EventsOf(bytes, 1);
    return events.empty() ? "" : events.back();
  };
  // Not masked.
  EXPECT_EQ(last(std::string("\x82\x01x", 3)), protocol_error);
  // A reserved bit, opcodes that are none.
  EXPECT_EQ(last("\xc2\x81maskx"), protocol_error);
  EXPECT_EQ(last(TestFrame(3, "x")), protocol_error);
  EXPECT_EQ(last(TestFrame(11, "x")), protocol_error);
  // A continuation of nothing, and a message amid another.
  EXPECT_EQ(last(TestFrame(0, "x")), protocol_error);
  EXPECT_EQ(last(TestFrame(kTestText, "a", false) + TestFrame(kTestText, "b")),
            protocol_error);
  // Control frames are short and whole.
  EXPECT_EQ(last(TestFrame(kTestPing, std::string(126, 'x'))), protocol_error);
  EXPECT_EQ(last(TestFrame(kTestPing, "x", false)), protocol_error);
  // Lengths longer than they need be, and one that is negative.
  EXPECT_EQ(last(std::string("\x82\xfe\x00\x01maskx", 9)), protocol_error);
  EXPECT_EQ(last(std::string("\x82\xff\0\0\0\0\0\0\xff\xff"
                             "mask",
                             14)),
            protocol_error);
  EXPECT_EQ(last(std::string("\x82\xff\x80\0\0\0\0\0\0\0mask", 14)),
            protocol_error);
}

TEST(WebSocketTest, BelievesNoLengthBeforeItsBytesAreThere) {
  const std::string too_large = "1009";
  EXPECT_THAT(EventsOf(TestFrameHead(kTestBinary, kMaxBytes + 1), 1),
              ElementsAre(too_large));
  EXPECT_THAT(EventsOf(TestFrameHead(kTestBinary, INT64_MAX), 1),
              ElementsAre(too_large));
  // In pieces as well.
  std::string pieces = TestFrame(kTestText, std::string(600, 'x'), false);
  pieces += TestFrameHead(0, 600, true);
  EXPECT_THAT(EventsOf(pieces, 100), ElementsAre(too_large));
  EXPECT_THAT(EventsOf(TestFrame(kTestText, std::string(kMaxBytes, 'x')), 100),
              ElementsAre("text " + std::string(kMaxBytes, 'x')));
}

TEST(WebSocketTest, AsksForRoomBeforeItTakesIt) {
  EXPECT_THAT(EventsOf(TestFrame(kTestText, std::string(200, 'x')), 100,
                       /*room=*/0),
              ElementsAre("1013"));
}

TEST(WebSocketTest, WritesFramesOfEverySize) {
  EXPECT_EQ(WebSocketMessage(true, "hi"), std::string("\x81\x02hi"));
  EXPECT_EQ(WebSocketMessage(false, std::string(126, 'x')).substr(0, 4),
            std::string("\x82\x7e\x00\x7e", 4));
  EXPECT_EQ(WebSocketMessage(false, std::string(65536, 'x')).substr(0, 10),
            std::string("\x82\x7f\0\0\0\0\0\x01\0\0", 10));
  EXPECT_EQ(WebSocketPong("p"), std::string("\x8a\x01p"));
  const std::string close =
      WebSocketCloseFrame(WebSocketClose::kGoingAway, std::string(500, 'x'));
  EXPECT_EQ(close.substr(0, 4), std::string("\x88\x7d\x03\xe9", 4));
  EXPECT_EQ(close.size(), 2u + 125);
}

// What an upgraded connection promises: echoes until it is told "end".
class EchoSocketHandler final : public HttpHandler {
 public:
  std::optional<HttpResponse> CheckHead(const HttpRequest&) override {
    return std::nullopt;
  }
  HttpResponse Handle(const HttpRequest& request) override {
    auto response = AcceptWebSocket(request, "");
    if (!response.has_value()) return {.status = 400};
    response->upgrade = [](HttpDuplex& duplex) { Echo(duplex); };
    return *std::move(response);
  }
  HttpResponse Error(int status) override { return {.status = status}; }
  std::vector<std::pair<std::string, std::string>> CommonHeaders(
      const HttpRequest&) override {
    return {{"X-Common", "yes"}};
  }

 private:
  static void Echo(HttpDuplex& duplex) {
    WebSocketReader reader(1 << 20, [](size_t) { return true; });
    std::string buffer(1000, '\0');
    const base::SteadyClock clock;
    for (;;) {
      if (!duplex.SetIdle(!reader.is_amid())) return;
      const auto ready = duplex.Wait(true, -1, base::MonotonicTime::max());
      if (!ready.can_read) continue;
      const ssize_t got = duplex.ReadSome(buffer.data(), buffer.size());
      if (got < 0) return;
      absl::string_view bytes(buffer.data(), static_cast<size_t>(got));
      while (!bytes.empty()) {
        const bool was_amid = reader.is_amid();
        const Event event = reader.Read(bytes);
        if (reader.is_amid() && !was_amid) duplex.BeginArrival();
        if (event != Event::kMessage) continue;
        duplex.EndArrival();
        const std::string message = reader.TakeMessage();
        if (!duplex.Write(WebSocketMessage(true, message))) return;
        if (message == "end") return;
      }
    }
  }
};

class WebSocketServerTest : public ::testing::Test {
 protected:
  WebSocketServerTest() { options_.listen = "127.0.0.1:0"; }
  void Start() {
    auto server = HttpServer::Start(options_, handler_, clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  const base::SteadyClock clock_{};
  HttpServerOptions options_;
  EchoSocketHandler handler_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(WebSocketServerTest, GoesBothWaysOnceItIsUpgraded) {
  Start();
  TestSocket socket(server_->address(), "/");
  // Before the answer to the handshake is there.
  socket.SendMessage(kTestText, "early");
  const std::string head = socket.ReadHead();
  EXPECT_THAT(head, HasSubstr("101 Switching Protocols"));
  EXPECT_THAT(head, HasSubstr("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));
  EXPECT_THAT(head, HasSubstr("X-Common: yes"));
  EXPECT_EQ(socket.ReadFrame().bytes, "early");
  const std::string large(300000, 'x');
  socket.SendMessage(kTestText, large);
  EXPECT_EQ(socket.ReadFrame().bytes, large);
  socket.SendMessage(kTestText, "end");
  EXPECT_EQ(socket.ReadFrame().bytes, "end");
  EXPECT_EQ(socket.ReadFrame().opcode, 0);
}

TEST_F(WebSocketServerTest, AnIdleOneMakesRoom) {
  options_.max_connections = 1;
  Start();
  TestSocket idle(server_->address(), "/");
  idle.ReadHead();
  idle.SendMessage(kTestText, "hello");
  EXPECT_EQ(idle.ReadFrame().bytes, "hello");
  // It may take a moment until it is idle again.
  for (;;) {
    TestSocket next(server_->address(), "/");
    if (next.ReadHead().find(" 101 ") == std::string::npos) continue;
    next.SendMessage(kTestText, "end");
    EXPECT_EQ(next.ReadFrame().bytes, "end");
    break;
  }
  EXPECT_EQ(idle.ReadFrame().opcode, 0);
}

TEST_F(WebSocketServerTest, AMessageThatDoesNotArriveEndsIt) {
  options_.stream.body_rate_grace = std::chrono::milliseconds(20);
  Start();
  TestSocket socket(server_->address(), "/");
  socket.ReadHead();
  socket.Send(TestFrameHead(kTestText, 100000));
  EXPECT_EQ(socket.ReadFrame().opcode, 0);
}

TEST_F(WebSocketServerTest, AnIdleOneEndsWhenTheServerStops) {
  Start();
  TestSocket socket(server_->address(), "/");
  socket.ReadHead();
  socket.SendMessage(kTestText, "hello");
  EXPECT_EQ(socket.ReadFrame().bytes, "hello");
  server_->Stop(std::chrono::hours(1));
  EXPECT_EQ(socket.ReadFrame().opcode, 0);
}

}  // namespace
}  // namespace treeline::http

#include "server/gateway/localize_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/byte_budget.h"
#include "common/base/error_info.h"
#include "common/http/testing_tls.h"
#include "common/http/testing_web_socket.h"
#include "common/wire/status.h"
#include "server/gateway/gateway.h"
#include "server/gateway/testing_dispatcher.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::gateway {
namespace {

using http::kTestBinary;
using http::kTestClose;
using http::kTestPing;
using http::kTestPong;
using http::kTestText;
using http::TestFrameHead;
using http::TestSocket;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr char kPath[] = "/treeline.v1.RelocalizationService/LocalizeStream";
constexpr char kPage[] = "https://app.example.com";
constexpr uint64_t kBudget = 8 << 20;

class LocalizeSocketTest : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.http.listen = "127.0.0.1:0";
    options_.http.max_body_mib = 1;
    options_.http.budget = &budget_;
    options_.allowed_origins = {kPage};
    Start();
  }
  void Start() {
    gateway_.reset();
    auto gateway =
        Gateway::Start(options_, dispatcher_,
                       {.ready = [this] { return ready_.load(); }}, clock_);
    ASSERT_TRUE(gateway.ok()) << gateway.status();
    gateway_ = *std::move(gateway);
  }

  // A stream that is open.
  std::unique_ptr<TestSocket> Open(const std::string& headers = "") {
    auto socket =
        std::make_unique<TestSocket>(gateway_->address(), kPath, headers);
    EXPECT_THAT(socket->ReadHead(), HasSubstr("HTTP/1.1 101 "));
    return socket;
  }
  // The head of the answer to a handshake.
  std::string HeadOf(const std::string& headers) {
    return TestSocket(gateway_->address(), kPath, headers).ReadHead();
  }

  static std::string Request(uint64_t id, const std::string& scene) {
    v1::LocalizeStreamRequest request;
    request.set_id(id);
    request.mutable_localize()->set_scene(scene);
    return request.SerializeAsString();
  }
  static v1::LocalizeStreamResponse Answer(TestSocket& socket) {
    const TestSocket::Frame frame = socket.ReadFrame();
    EXPECT_EQ(frame.opcode, kTestBinary);
    v1::LocalizeStreamResponse response;
    EXPECT_TRUE(response.ParseFromString(frame.bytes));
    return response;
  }
  // All that a stream does, over `socket`: in both directions messages of many
  // TLS records, and of several in one.
  void ExpectAStream(TestSocket& socket) {
    constexpr size_t kLarge = 300000;
    dispatcher_.on_localize = [](const v1::LocalizeRequest& request) {
      v1::LocalizeResponse response;
      response.set_scene(request.frame().color().encoded());
      return response;
    };
    v1::LocalizeStreamRequest large;
    large.set_id(1);
    large.mutable_localize()->mutable_frame()->mutable_color()->set_encoded(
        std::string(kLarge, 'x'));
    socket.SendMessage(kTestBinary, large.SerializeAsString());
    socket.Send(http::TestFrame(kTestBinary, Request(2, "hall")) +
                http::TestFrame(kTestBinary, Request(3, "hall")));
    EXPECT_THAT(Answer(socket).response().scene(), SizeIs(kLarge));
    EXPECT_EQ(Answer(socket).id(), 2u);
    EXPECT_EQ(Answer(socket).id(), 3u);
    socket.SendMessage(kTestPing, "are you there?");
    EXPECT_EQ(socket.ReadFrame().opcode, kTestPong);
  }
  static void ExpectClose(TestSocket& socket, int code,
                          const std::string& reason) {
    const TestSocket::Frame frame = socket.ReadFrame();
    EXPECT_EQ(frame.opcode, kTestClose);
    EXPECT_EQ(frame.code(), code);
    EXPECT_THAT(frame.reason(), HasSubstr(reason));
    EXPECT_EQ(socket.ReadFrame().opcode, 0);
  }
  void AwaitEmptyBudget() const {
    while (budget_.used_bytes() > 0) std::this_thread::yield();
  }

  const base::SteadyClock clock_{};
  const http::SelfSigned certificate_{};
  base::ByteBudget budget_{kBudget};
  GatewayOptions options_;
  TestingDispatcher dispatcher_;
  std::atomic<bool> ready_ = true;
  std::unique_ptr<Gateway> gateway_;
};

TEST_F(LocalizeSocketTest, AnswersFramesInTheirOrder) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest& request) {
    v1::LocalizeResponse response;
    response.set_scene(request.scene());
    return response;
  };
  const auto socket = Open();
  for (uint64_t id = 1; id <= 20; ++id) {
    ASSERT_TRUE(socket->SendMessage(kTestBinary,
                                    Request(id, absl::StrCat("scene-", id))));
  }
  for (uint64_t id = 1; id <= 20; ++id) {
    const v1::LocalizeStreamResponse answer = Answer(*socket);
    EXPECT_EQ(answer.id(), id);
    EXPECT_EQ(answer.response().scene(), absl::StrCat("scene-", id));
  }
  const std::vector<service::CallInfo> calls = dispatcher_.calls();
  ASSERT_THAT(calls, SizeIs(20));
  EXPECT_STREQ(calls[0].rpc, "LocalizeStream");
  EXPECT_STREQ(calls[0].transport, "http");
  // Each frame is let in, and counted, by itself.
  EXPECT_FALSE(calls[0].client.has_value());
}

TEST_F(LocalizeSocketTest, SpeaksJsonToThoseWhoDo) {
  const auto socket = Open();
  socket->SendMessage(kTestText, R"({"id":"7","localize":{"scene":"hall"}})");
  const TestSocket::Frame frame = socket->ReadFrame();
  EXPECT_EQ(frame.opcode, kTestText);
  EXPECT_THAT(frame.bytes, HasSubstr(R"("id":"7")"));
  EXPECT_EQ(dispatcher_.requests()[0].scene(), "hall");
  socket->SendMessage(kTestBinary, Request(8, "hall"));
  ExpectClose(*socket, 1007, "binary and text");
}

TEST_F(LocalizeSocketTest, AFrameThatFailsEndsNothingButItself) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest& request)
      -> absl::StatusOr<v1::LocalizeResponse> {
    if (request.scene() == "none") {
      return base::WithReason(absl::NotFoundError("no such scene"),
                              "SCENE_NOT_FOUND");
    }
    return v1::LocalizeResponse();
  };
  const auto socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "none"));
  socket->SendMessage(kTestBinary, Request(2, "hall"));
  const absl::Status error = wire::FromProto(Answer(*socket).error());
  EXPECT_TRUE(absl::IsNotFound(error));
  EXPECT_EQ(base::ErrorInfoOf(error).reason, "SCENE_NOT_FOUND");
  EXPECT_TRUE(Answer(*socket).has_response());
}

TEST_F(LocalizeSocketTest, ACamerasOldFramesAreDropped) {
  dispatcher_.scene_that_waits = "gate";
  const auto socket = Open();
  v1::LocalizeStreamRequest first;
  first.mutable_localize()->set_scene("gate");
  first.mutable_settings()->set_drop_oldest(true);
  first.mutable_settings()->set_max_pending(1);
  socket->SendMessage(kTestBinary, first.SerializeAsString());
  socket->SendMessage(kTestBinary, Request(1, "gate"));
  dispatcher_.AwaitCalls(2);
  for (uint64_t id = 2; id < 6; ++id) {
    socket->SendMessage(kTestBinary, Request(id, "hall"));
  }
  // Of 2 to 5, one may wait: it is with nobody yet.
  socket->SendMessage(kTestPing, "all read?");
  EXPECT_EQ(socket->ReadFrame().opcode, kTestPong);
  EXPECT_THAT(dispatcher_.calls(), SizeIs(2));
  EXPECT_THAT(dispatcher_.rejected(), ElementsAre("hall", "hall", "hall"));
}

TEST_F(LocalizeSocketTest, AnswersPings) {
  const auto socket = Open();
  socket->SendMessage(kTestPing, "are you there?");
  const TestSocket::Frame pong = socket->ReadFrame();
  EXPECT_EQ(pong.opcode, kTestPong);
  EXPECT_EQ(pong.bytes, "are you there?");
}

TEST_F(LocalizeSocketTest, AClientThatClosesOrGoesCancelsItsFrames) {
  dispatcher_.waits_for_stop = true;
  auto socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  dispatcher_.AwaitCalls(1);
  socket->SendMessage(kTestClose, "");
  ExpectClose(*socket, 1000, "");
  EXPECT_TRUE(dispatcher_.calls()[0].stop.stop_requested());
  socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  dispatcher_.AwaitCalls(2);
  const std::stop_token stop = dispatcher_.calls()[1].stop;
  socket.reset();
  while (!stop.stop_requested()) std::this_thread::yield();
  AwaitEmptyBudget();
}

class LocalizeSocketTlsTest : public LocalizeSocketTest {
 protected:
  void SetUp() override {
    options_.http.tls = http::ServerTls{
        .configure =
            [this](SSL_CTX& context) {
              return certificate_.Configure(context);
            },
        .client_names = [](SSL*) { return std::vector<std::string>{"robot"}; }};
    LocalizeSocketTest::SetUp();
  }
  std::unique_ptr<TestSocket> OpenTls() {
    auto socket = std::make_unique<TestSocket>(
        std::make_unique<http::TlsClient>(gateway_->address()),
        gateway_->address(), kPath, "");
    EXPECT_THAT(socket->ReadHead(), HasSubstr("HTTP/1.1 101 "));
    return socket;
  }
};

TEST_F(LocalizeSocketTlsTest, AnswersAndSaysGoodbye) {
  const auto socket = OpenTls();
  ExpectAStream(*socket);
  EXPECT_THAT(dispatcher_.calls()[0].credentials.certificate_names,
              ElementsAre("robot"));
  socket->SendMessage(kTestClose, "");
  ExpectClose(*socket, 1000, "");
  AwaitEmptyBudget();
}

TEST_F(LocalizeSocketTlsTest, AServerThatStopsSaysSo) {
  const auto socket = OpenTls();
  ExpectAStream(*socket);
  gateway_->Stop(std::chrono::hours(1));
  ExpectClose(*socket, 1001, "DRAINING");
}

TEST_F(LocalizeSocketTlsTest, AClientThatGoesCancelsItsFrames) {
  dispatcher_.waits_for_stop = true;
  auto socket = OpenTls();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  dispatcher_.AwaitCalls(1);
  const std::stop_token stop = dispatcher_.calls()[0].stop;
  socket.reset();
  while (!stop.stop_requested()) std::this_thread::yield();
  AwaitEmptyBudget();
}

TEST_F(LocalizeSocketTlsTest, HalfAMessageHoldsNothingForLong) {
  options_.http.stream.body_rate_grace = std::chrono::milliseconds(20);
  Start();
  const auto socket = OpenTls();
  socket->Send(TestFrameHead(kTestBinary, 1 << 20));
  ExpectClose(*socket, 1008, "REQUEST_TIMEOUT");
  AwaitEmptyBudget();
}

// ---- access ----

TEST_F(LocalizeSocketTest, WhoIsNotLetInOpensNothing) {
  dispatcher_.admission = absl::UnauthenticatedError("who are you?");
  EXPECT_THAT(HeadOf(""), HasSubstr("HTTP/1.1 401 "));
  dispatcher_.admission = absl::PermissionDeniedError("not you");
  EXPECT_THAT(HeadOf(""), HasSubstr("HTTP/1.1 403 "));
}

TEST_F(LocalizeSocketTest, ATraceComesInAHeaderOrAsAProtocol) {
  const std::string trace = "00-0af7651916cd43dd8448eb211c80319c-";
  const std::string header = "traceparent: " + trace;
  const std::string protocol =
      "Sec-WebSocket-Protocol: treeline.v1, treeline.traceparent." + trace;
  for (const std::string& headers : {header + "b7ad6b7169203331-01\r\n",
                                     protocol + "b7ad6b7169203332-01\r\n",
                                     protocol + "b7ad6b7169203333-01\r\n" +
                                         header + "b7ad6b7169203334-01\r\n"}) {
    const auto socket = Open(headers);
    socket->SendMessage(kTestBinary, Request(1, "hall"));
    Answer(*socket);
  }
  const auto calls = dispatcher_.calls();
  ASSERT_THAT(calls, SizeIs(3));
  EXPECT_EQ(calls[0].traceparent, trace + "b7ad6b7169203331-01");
  EXPECT_EQ(calls[1].traceparent, trace + "b7ad6b7169203332-01");
  EXPECT_EQ(calls[2].traceparent, trace + "b7ad6b7169203334-01");
}

TEST_F(LocalizeSocketTest, ATokenComesInAHeaderOrAsAProtocol) {
  auto socket = Open("Authorization: Bearer abc.def\r\n");
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  Answer(*socket);
  socket = std::make_unique<TestSocket>(
      gateway_->address(), kPath,
      "Sec-WebSocket-Protocol: treeline.v1, treeline.bearer.ghi.jkl\r\n");
  // The token is not told back.
  const std::string head = socket->ReadHead();
  EXPECT_THAT(head, HasSubstr("Sec-WebSocket-Protocol: treeline.v1\r\n"));
  EXPECT_THAT(head, Not(HasSubstr("ghi")));
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  Answer(*socket);
  const auto calls = dispatcher_.calls();
  ASSERT_THAT(calls, SizeIs(2));
  EXPECT_EQ(calls[0].credentials.bearer_token, "abc.def");
  EXPECT_EQ(calls[1].credentials.bearer_token, "ghi.jkl");
}

TEST_F(LocalizeSocketTest, ATokenThatExpiresEndsTheStream) {
  dispatcher_.on_localize =
      [](const v1::LocalizeRequest&) -> absl::StatusOr<v1::LocalizeResponse> {
    return base::WithReason(absl::UnauthenticatedError("it was good once"),
                            "TOKEN_EXPIRED");
  };
  const auto socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  EXPECT_TRUE(
      absl::IsUnauthenticated(wire::FromProto(Answer(*socket).error())));
  ExpectClose(*socket, 1008, "TOKEN_EXPIRED");
}

// Browsers neither ask before they open a WebSocket nor hide what it says.
TEST_F(LocalizeSocketTest, PagesOfOtherOriginsOpenNothing) {
  EXPECT_THAT(HeadOf("Origin: https://evil.example.com\r\n"),
              HasSubstr("HTTP/1.1 403 "));
  EXPECT_THAT(HeadOf("Origin: null\r\n"), HasSubstr("HTTP/1.1 403 "));
  EXPECT_THAT(HeadOf(absl::StrCat("Origin: ", kPage, "\r\n")),
              HasSubstr("HTTP/1.1 101 "));
}

TEST_F(LocalizeSocketTest, WhatIsNoHandshakeIsRefused) {
  const http::RawClient client(gateway_->address());
  client.Send(absl::StrCat("GET ", kPath, " HTTP/1.1\r\nHost: a\r\n\r\n"));
  EXPECT_THAT(client.ReadSome(), HasSubstr("HTTP/1.1 426 "));
  EXPECT_THAT(HeadOf("Sec-WebSocket-Protocol: chat\r\n"),
              HasSubstr("HTTP/1.1 400 "));
}

// ---- limits ----

TEST_F(LocalizeSocketTest, MessagesAreAsLargeAsBodiesMayBe) {
  const auto socket = Open();
  v1::LocalizeStreamRequest request;
  request.mutable_localize()->mutable_frame()->mutable_color()->set_encoded(
      std::string((1 << 20) - 100, 'x'));
  socket->SendMessage(kTestBinary, request.SerializeAsString());
  EXPECT_TRUE(Answer(*socket).has_response());
  AwaitEmptyBudget();
  // Refused by its head alone.
  socket->Send(TestFrameHead(kTestBinary, (1 << 20) + 1));
  ExpectClose(*socket, 1009, "REQUEST_TOO_LARGE");
  AwaitEmptyBudget();
}

TEST_F(LocalizeSocketTest, MessagesThatWouldBecomeLargeAreRefused) {
  const auto socket = Open();
  v1::LocalizeStreamRequest request;
  for (int i = 0; i < 20001; ++i) {
    request.mutable_localize()->add_candidate_scenes();
  }
  socket->SendMessage(kTestBinary, request.SerializeAsString());
  ExpectClose(*socket, 1007, "INVALID_REQUEST");
  EXPECT_THAT(dispatcher_.calls(), IsEmpty());
}

TEST_F(LocalizeSocketTest, BytesThatAreNoFramesOrMessagesEndIt) {
  auto socket = Open();
  socket->Send("GET / HTTP/1.1\r\n\r\n");
  ExpectClose(*socket, 1002, "INVALID_REQUEST");
  socket = Open();
  socket->SendMessage(kTestText, "{");
  ExpectClose(*socket, 1007, "INVALID_REQUEST");
}

TEST_F(LocalizeSocketTest, ThereIsOneBudgetForAll) {
  base::ByteLease others(&budget_);
  ASSERT_TRUE(others.Resize(kBudget));
  const auto socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  ExpectClose(*socket, 1013, "OVERLOADED");
}

TEST_F(LocalizeSocketTest, HalfAMessageHoldsNothingForLong) {
  options_.http.stream.body_rate_grace = std::chrono::milliseconds(20);
  Start();
  const auto socket = Open();
  socket->Send(TestFrameHead(kTestBinary, 1 << 20));
  socket->Send(std::string(1000, 'x'));
  ExpectClose(*socket, 1008, "REQUEST_TIMEOUT");
  AwaitEmptyBudget();
}

TEST_F(LocalizeSocketTest, NoMoreIsReadThanMayBePending) {
  dispatcher_.scene_that_waits = "gate";
  const auto socket = Open();
  v1::LocalizeStreamRequest first;
  first.mutable_localize()->set_scene("gate");
  first.mutable_settings()->set_max_pending(2);
  socket->SendMessage(kTestBinary, first.SerializeAsString());
  for (uint64_t id = 1; id < 6; ++id) {
    socket->SendMessage(kTestBinary, Request(id, "hall"));
  }
  dispatcher_.AwaitCalls(2);
  // The first holds one place, the second, answered, the other. Not even a
  // goodbye is read before they go.
  socket->SendMessage(kTestPing, "all read?");
  const std::stop_token stop = dispatcher_.calls()[0].stop;
  EXPECT_FALSE(stop.stop_requested());
  EXPECT_THAT(dispatcher_.calls(), SizeIs(2));
  EXPECT_THAT(dispatcher_.rejected(), IsEmpty());
}

TEST_F(LocalizeSocketTest, ThousandsOfMessagesAreAnswered) {
  const auto socket = Open();
  std::string burst;
  for (uint64_t id = 0; id < 5000; ++id) {
    burst += http::TestFrame(kTestBinary, Request(id, ""));
  }
  std::thread sender([&] { EXPECT_TRUE(socket->Send(burst)); });
  for (uint64_t id = 0; id < 5000; ++id) {
    ASSERT_EQ(Answer(*socket).id(), id);
  }
  sender.join();
  AwaitEmptyBudget();
}

TEST_F(LocalizeSocketTest, AClientThatDoesNotReadIsLeft) {
  options_.http.stream.write_timeout = std::chrono::milliseconds(50);
  Start();
  dispatcher_.on_localize = [](const v1::LocalizeRequest&) {
    v1::LocalizeResponse response;
    response.set_scene(std::string(1 << 20, 'x'));
    return response;
  };
  const auto socket = Open();
  for (uint64_t id = 0; id < 64; ++id) {
    if (!socket->SendMessage(kTestBinary, Request(id, ""))) break;
  }
  dispatcher_.AwaitCalls(1);
  const std::stop_token stop = dispatcher_.calls()[0].stop;
  while (!stop.stop_requested()) std::this_thread::yield();
  // It reads the part that was sent, and then the end.
  int answers = 0;
  while (socket->ReadFrame().opcode == kTestBinary) ++answers;
  EXPECT_LT(answers, 64);
  AwaitEmptyBudget();
}

// ---- the end ----

TEST_F(LocalizeSocketTest, AStreamWithNothingToDoEnds) {
  options_.http.idle_timeout = std::chrono::milliseconds(50);
  Start();
  const auto socket = Open();
  ExpectClose(*socket, 1000, "IDLE");
}

TEST_F(LocalizeSocketTest, AServerThatDrainsAnswersWhatItHasRead) {
  dispatcher_.on_localize = [this](const v1::LocalizeRequest&) {
    ready_ = false;
    return v1::LocalizeResponse();
  };
  const auto socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  EXPECT_EQ(Answer(*socket).id(), 1u);
  ExpectClose(*socket, 1001, "DRAINING");
  // New ones end at once.
  ExpectClose(*Open(), 1001, "DRAINING");
}

TEST_F(LocalizeSocketTest, AServerThatStopsWaitsForNoIdleStream) {
  const auto socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  Answer(*socket);
  gateway_->Stop(std::chrono::hours(1));
  ExpectClose(*socket, 1001, "DRAINING");
}

TEST_F(LocalizeSocketTest, AnIdleStreamMakesRoomAndIsToldSo) {
  options_.http.max_connections = 1;
  Start();
  const auto socket = Open();
  socket->SendMessage(kTestBinary, Request(1, "hall"));
  Answer(*socket);
  // The next one has no room until the first has nothing to do.
  while (absl::StrContains(HeadOf(""), " 503 ")) std::this_thread::yield();
  ExpectClose(*socket, 1001, "DRAINING");
}

}  // namespace
}  // namespace treeline::gateway

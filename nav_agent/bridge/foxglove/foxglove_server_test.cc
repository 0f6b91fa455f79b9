#include "nav_agent/bridge/foxglove/foxglove_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/http/testing_web_socket.h"
#include "nav_agent/bridge/foxglove/live_topics.h"

namespace treeline::foxglove {
namespace {

using http::TestSocket;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kProtocol[] =
    "Sec-WebSocket-Protocol: foxglove.sdk.v1, foxglove.websocket.v1\r\n";

class FoxgloveServerTest : public ::testing::Test {
 protected:
  FoxgloveServerTest() {
    info_.version = "1.2";
    info_.map = std::make_shared<behavior::NavigatorMap>();
    Start({});
  }
  ~FoxgloveServerTest() override { hub_.Close(); }

  void Start(FoxgloveServerOptions options) {
    options.listen = "127.0.0.1:0";
    server_.reset();
    auto server =
        FoxgloveServer::Start(info_, hub_, nullptr, std::move(options), clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  std::unique_ptr<TestSocket> Connect(const std::string& headers = kProtocol) {
    return std::make_unique<TestSocket>(server_->address(), "/", headers);
  }
  // One that has been told what there is.
  std::unique_ptr<TestSocket> Viewer() {
    auto viewer = Connect();
    EXPECT_THAT(viewer->ReadHead(), StartsWith("HTTP/1.1 101 "));
    EXPECT_EQ(json::parse(viewer->ReadFrame().bytes)["op"], "serverInfo");
    EXPECT_EQ(json::parse(viewer->ReadFrame().bytes)["op"], "advertise");
    return viewer;
  }
  void Publish() {
    agent_service::AgentState state;
    state.snapshot.command.forward_mps = 0.25;
    hub_.Publish(std::move(state));
  }
  static void Subscribe(const TestSocket& viewer, uint32_t id,
                        LiveTopic topic) {
    const json request = {
        {"op", "subscribe"},
        {"subscriptions",
         {{{"id", id}, {"channelId", static_cast<uint32_t>(topic)}}}}};
    ASSERT_TRUE(viewer.SendMessage(http::kTestText, request.dump()));
  }

  agent_service::AgentInfo info_;
  agent_service::AgentHub hub_{agent_service::AgentHubOptions()};
  const base::SteadyClock clock_;
  std::unique_ptr<FoxgloveServer> server_;
};

TEST_F(FoxgloveServerTest, ShowsWhatIsSubscribedTo) {
  const auto viewer = Viewer();
  Publish();
  Subscribe(*viewer, 42, LiveTopic::kCommand);
  const TestSocket::Frame frame = viewer->ReadFrame();
  EXPECT_EQ(frame.opcode, http::kTestBinary);
  EXPECT_EQ(frame.bytes.substr(0, 5), std::string("\x01\x2a\x00\x00\x00", 5));
  // The next state is told without being asked for.
  Publish();
  EXPECT_EQ(viewer->ReadFrame().opcode, http::kTestBinary);
}

TEST_F(FoxgloveServerTest, SpeaksTheProtocolThatItPrefers) {
  EXPECT_THAT(Connect()->ReadHead(),
              HasSubstr("Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n"));
  EXPECT_THAT(
      Connect("Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n")->ReadHead(),
      HasSubstr("Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n"));
  EXPECT_THAT(Connect("Sec-WebSocket-Protocol: mqtt\r\n")->ReadHead(),
              StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(Connect("")->ReadHead(), StartsWith("HTTP/1.1 400 "));
}

TEST_F(FoxgloveServerTest, PagesOfOthersMayNotWatch) {
  const std::string protocol = kProtocol;
  EXPECT_THAT(
      Connect(protocol + "Origin: https://evil.example\r\n")->ReadHead(),
      StartsWith("HTTP/1.1 403 "));
  EXPECT_THAT(
      Connect(protocol + "Origin: https://app.foxglove.dev\r\n")->ReadHead(),
      StartsWith("HTTP/1.1 101 "));
  Start({.origins = {"*"}});
  EXPECT_THAT(
      Connect(protocol + "Origin: https://evil.example\r\n")->ReadHead(),
      StartsWith("HTTP/1.1 101 "));
}

TEST_F(FoxgloveServerTest, TellsABrowserWhatThisIs) {
  const http::RawClient client(server_->address());
  client.Send("GET / HTTP/1.1\r\nHost: robot:8765\r\n\r\n");
  const std::string answer = client.ReadSome();
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 426 "));
}

TEST_F(FoxgloveServerTest, SaysWhatItDoesNotOffer) {
  const auto viewer = Viewer();
  viewer->SendMessage(http::kTestText, R"({"op":"advertise","channels":[]})");
  json status = json::parse(viewer->ReadFrame().bytes);
  EXPECT_EQ(status["op"], "status");
  EXPECT_EQ(status["level"], 1);
  viewer->SendMessage(http::kTestBinary, "\x01publish");
  EXPECT_EQ(json::parse(viewer->ReadFrame().bytes)["level"], 1);
  Subscribe(*viewer, 1, LiveTopic::kCount);
  status = json::parse(viewer->ReadFrame().bytes);
  EXPECT_EQ(status["level"], 2);
  EXPECT_THAT(status["message"], HasSubstr("no channel 12"));
  // It goes on all the same.
  viewer->SendMessage(http::kTestPing, "x");
  EXPECT_EQ(viewer->ReadFrame().opcode, http::kTestPong);
}

TEST_F(FoxgloveServerTest, EndsOneThatSendsTooMuch) {
  const auto viewer = Viewer();
  viewer->Send(http::TestFrameHead(http::kTestText, uint64_t{1} << 40));
  EXPECT_EQ(viewer->ReadFrame().code(), 1009);
}

TEST_F(FoxgloveServerTest, BoundsSubscriptions) {
  const auto viewer = Viewer();
  json list = json::array();
  for (int id = 0; id < 300; ++id) {
    list.push_back({{"id", id}, {"channelId", 0}});
  }
  viewer->SendMessage(
      http::kTestText,
      json({{"op", "subscribe"}, {"subscriptions", list}}).dump());
  EXPECT_THAT(json::parse(viewer->ReadFrame().bytes)["message"],
              HasSubstr("more than 256"));
}

TEST_F(FoxgloveServerTest, RefusesTooManyViewers) {
  Start({.max_viewers = 1});
  const auto first = Viewer();
  const auto second = Connect();
  EXPECT_THAT(second->ReadHead(), StartsWith("HTTP/1.1 101 "));
  EXPECT_EQ(second->ReadFrame().code(), 1013);
}

TEST_F(FoxgloveServerTest, ViewersEndWithTheAgent) {
  const auto viewer = Viewer();
  hub_.Close();
  const TestSocket::Frame frame = viewer->ReadFrame();
  EXPECT_EQ(frame.opcode, http::kTestClose);
  EXPECT_EQ(frame.code(), 1001);
}

}  // namespace
}  // namespace treeline::foxglove

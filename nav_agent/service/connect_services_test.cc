// The agent's services over Connect, from socket to hub.
#include "nav_agent/service/connect_services.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/connect_rpc/connect_message.h"
#include "common/http/http_server.h"
#include "nav_agent/service/http_api.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kNavigation[] = "/treeline.v1.NavigationService/";
constexpr char kSimulation[] = "/treeline.v1.SimulationService/";
const httplib::Headers kVersion = {{"Connect-Protocol-Version", "1"}};

class ConnectServicesTest : public ::testing::Test {
 protected:
  void Start(bool is_simulated = true, int max_streams = 16) {
    agent_ = std::make_unique<SteppingAgent>(is_simulated);
    HttpApiOptions options;
    options.max_streams = max_streams;
    api_ = std::make_unique<HttpApi>(agent_->commands, metrics_, nullptr,
                                     nullptr, options, clock_);
    auto server = http::HttpServer::Start(
        {.listen = "127.0.0.1:0", .max_body_mib = 1}, *api_, clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  ~ConnectServicesTest() override {
    if (agent_ != nullptr) agent_->Close();
  }
  httplib::Client Client() const {
    return httplib::Client("http://" + server_->address());
  }
  httplib::Result Json(const std::string& path, const std::string& body) const {
    return Client().Post(path, kVersion, body, "application/json");
  }
  // Reads a stream of binary messages until `goes_on` is false of one. The JSON
  // of its end, if that came.
  template <typename Response>
  std::string Read(const std::string& method,
                   const google::protobuf::Message& request,
                   const std::function<bool(const Response&)>& goes_on) const {
    httplib::Request post;
    post.method = "POST";
    post.path = kNavigation + method;
    post.headers = kVersion;
    post.set_header("Content-Type", "application/connect+proto");
    post.body = connect_rpc::InEnvelope(request.SerializeAsString());
    std::string rest;
    std::string end;
    post.content_receiver = [&](const char* data, size_t size, uint64_t,
                                uint64_t) {
      rest.append(data, size);
      for (;;) {
        if (rest.size() < 5) return true;
        size_t length = 0;
        for (size_t i = 1; i < 5; ++i) {
          length = length << 8 | static_cast<uint8_t>(rest[i]);
        }
        if (rest.size() < 5 + length) return true;
        const std::string bytes = rest.substr(5, length);
        const bool is_end = rest[0] == '\2';
        rest.erase(0, 5 + length);
        if (is_end) {
          end = bytes;
          return true;
        }
        Response response;
        EXPECT_TRUE(response.ParseFromString(bytes));
        if (!goes_on(response)) return false;
      }
    };
    Client().send(post);
    return end;
  }
  bool BecomesCancelled() const {
    uint64_t seen = 0;
    for (;;) {
      const auto state =
          agent_->hub.WaitForNewer(seen, absl::Now() + absl::Seconds(60));
      if (state == nullptr) return false;
      seen = state->number;
      if (state->snapshot.goal.has_value() &&
          state->snapshot.goal->state == behavior::GoalState::kCancelled) {
        return true;
      }
    }
  }

  const base::SteadyClock clock_{};
  AgentMetrics metrics_;
  std::unique_ptr<SteppingAgent> agent_;
  std::unique_ptr<HttpApi> api_;
  std::unique_ptr<http::HttpServer> server_;
};

v1::NavigateRequest GoalAt(double x_m, double y_m) {
  v1::NavigateRequest request;
  request.add_poses()->set_x_m(x_m);
  request.mutable_poses(0)->set_y_m(y_m);
  return request;
}

TEST_F(ConnectServicesTest, NavigateTellsHowItGoesUntilTheGoal) {
  Start();
  agent_->navigator.may_arrive = false;
  std::vector<v1::NavigateResponse> feedback;
  const std::string end = Read<v1::NavigateResponse>(
      "Navigate", GoalAt(1, 1), [&](const v1::NavigateResponse& one) {
        feedback.push_back(one);
        agent_->navigator.may_arrive = true;
        return true;
      });
  EXPECT_EQ(end, "{}");
  ASSERT_GE(feedback.size(), 2U);
  EXPECT_EQ(feedback[0].goal().state(), v1::GOAL_STATE_ACTIVE);
  EXPECT_TRUE(feedback.back().is_final());
  EXPECT_EQ(feedback.back().goal().state(), v1::GOAL_STATE_SUCCEEDED);
}

TEST_F(ConnectServicesTest, AGoalEndsWithItsCallUnlessItShouldStay) {
  Start();
  v1::NavigateRequest request = GoalAt(50000, 0);
  request.set_keep_when_call_ends(true);
  const auto hang_up = [](const v1::NavigateResponse&) { return false; };
  Read<v1::NavigateResponse>("Navigate", request, hang_up);
  EXPECT_EQ(agent_->hub.Latest()->snapshot.goal->state,
            behavior::GoalState::kActive);
  request.set_keep_when_call_ends(false);
  Read<v1::NavigateResponse>("Navigate", request, hang_up);
  EXPECT_TRUE(BecomesCancelled());
}

TEST_F(ConnectServicesTest, ABadGoalIsTheEndOfItsStream) {
  Start();
  const std::string end = Read<v1::NavigateResponse>(
      "Navigate", v1::NavigateRequest(),
      [](const v1::NavigateResponse&) { return true; });
  EXPECT_THAT(end, HasSubstr(R"("code":"invalid_argument")"));
  EXPECT_THAT(end, HasSubstr("a pose at least"));
}

TEST_F(ConnectServicesTest, StreamStateHasStatesScenesAndPastEvents) {
  Start();
  agent_->hub.AddEvent(1, "plan", "long ago");
  agent_->hub.AddEvent(2, "plan", "a path of 3 m");
  v1::StreamStateRequest request;
  request.set_past_events(1);
  request.set_with_scene(true);
  std::vector<v1::StreamStateResponse> all;
  Read<v1::StreamStateResponse>("StreamState", request,
                                [&](const v1::StreamStateResponse& one) {
                                  all.push_back(one);
                                  return all.size() < 2;
                                });
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].state().mode(), v1::NAVIGATOR_MODE_IDLE);
  ASSERT_EQ(all[0].events_size(), 1);
  EXPECT_EQ(all[0].events(0).text(), "a path of 3 m");
  EXPECT_TRUE(all[0].has_scene());
  EXPECT_FALSE(all[1].has_scene());
}

TEST_F(ConnectServicesTest, StreamStateRefusesWhatIsOutOfRange) {
  Start();
  v1::StreamStateRequest request;
  request.set_past_events(1001);
  const auto go_on = [](const v1::StreamStateResponse&) { return true; };
  EXPECT_THAT(Read<v1::StreamStateResponse>("StreamState", request, go_on),
              HasSubstr("past_events"));
  request.set_past_events(0);
  request.set_rate_hz(11);
  EXPECT_THAT(Read<v1::StreamStateResponse>("StreamState", request, go_on),
              HasSubstr("rate_hz"));
}

TEST_F(ConnectServicesTest, StreamsAreBoundedAndEndWithTheAgent) {
  Start(/*is_simulated=*/true, /*max_streams=*/1);
  std::atomic<bool> is_open = false;
  std::string end;
  std::jthread first([&] {
    end = Read<v1::StreamStateResponse>("StreamState", v1::StreamStateRequest(),
                                        [&](const v1::StreamStateResponse&) {
                                          is_open = true;
                                          return true;
                                        });
  });
  while (!is_open) std::this_thread::yield();
  EXPECT_THAT(Read<v1::StreamStateResponse>(
                  "StreamState", v1::StreamStateRequest(),
                  [](const v1::StreamStateResponse&) { return true; }),
              HasSubstr("resource_exhausted"));
  agent_->Close();
  first.join();
  EXPECT_THAT(end, HasSubstr("unavailable"));
}

TEST_F(ConnectServicesTest, UnaryCallsReachRobotAndSimulation) {
  Start();
  const std::string navigation = kNavigation;
  const std::string simulation = kSimulation;
  EXPECT_EQ(Json(navigation + "Pause", "{}")->body, "{}");
  EXPECT_EQ(Json(navigation + "Resume", "{}")->status, 200);
  EXPECT_EQ(Json(navigation + "FindYourself", "{}")->status, 200);
  EXPECT_EQ(Json(navigation + "SetInitialPose",
                 R"({"mapFromBase":{"xM":1,"yM":0.5,"yawRad":0.1}})")
                ->status,
            200);
  EXPECT_THAT(Json(navigation + "Cancel", "{}")->body, HasSubstr("not_found"));
  EXPECT_THAT(Json(navigation + "GetInfo", "{}")->body,
              HasSubstr(R"("mapName":"house")"));
  EXPECT_THAT(Json(navigation + "GetMaps", "{}")->body,
              HasSubstr(R"("freeCells":"42")"));
  EXPECT_EQ(Json(simulation + "Kidnap", "{}")->status, 200);
  EXPECT_EQ(Json(simulation + "AddObstacle", R"({"xM":1,"sizeM":0.4})")->body,
            R"({"name":"box-1"})");
  EXPECT_EQ(Json(simulation + "RemoveObstacle", R"({"name":"x"})")->status,
            404);
  EXPECT_EQ(Json(simulation + "InjectFault",
                 R"({"target":"laser","kind":"silent","durationS":3})")
                ->status,
            200);
  agent_->Close();
  EXPECT_EQ(agent_->navigator.snapshot.pose->pose.map_from_base.yaw_rad, 0.1);
  EXPECT_THAT(agent_->simulation.calls,
              ElementsAre("kidnap anywhere", "obstacle of 0.4 on 0",
                          "fault laser silent 3 1"));
}

TEST_F(ConnectServicesTest, RoutesAreKeptListedAndRemoved) {
  Start();
  const std::string navigation = kNavigation;
  const auto put = [&](const std::string& route) {
    return Json(navigation + "PutRoutes", "{\"routes\":[" + route + "]}");
  };
  auto answer = put(
      R"({"name":"patrol","loop":true,"waypoints":[{"xM":1,"waitS":3},{"yawRad":0}]})");
  ASSERT_EQ(answer->status, 200) << answer->body;
  EXPECT_THAT(answer->body, HasSubstr("\"revision\":\"2\""));
  answer = Json(navigation + "GetRoutes", "{}");
  EXPECT_THAT(answer->body, HasSubstr("\"name\":\"patrol\""));
  EXPECT_THAT(answer->body, HasSubstr("\"waitS\":3"));
  // A heading of zero is one.
  EXPECT_THAT(answer->body, HasSubstr("\"yawRad\":0"));
  EXPECT_THAT(answer->body, HasSubstr("MISSED_POLICY_GO_ON"));
  answer = put(R"({"name":"x","waypoints":[{"level":7}]})");
  EXPECT_EQ(answer->status, 400);
  EXPECT_THAT(answer->body, HasSubstr("level 7"));
  EXPECT_EQ(put(R"({"waypoints":[{}]})")->status, 400);
  EXPECT_EQ(Json(navigation + "PutRoutes", "{}")->status, 400);
  EXPECT_EQ(
      Json(navigation + "RemoveRoutes", R"({"names":["patrol","x"]})")->status,
      404);
  EXPECT_EQ(
      Json(navigation + "RemoveRoutes", R"({"names":["patrol"]})")->status,
      200);
  EXPECT_THAT(Json(navigation + "GetRoutes", "{}")->body,
              testing::Not(HasSubstr("patrol")));
  EXPECT_EQ(Json(navigation + "ResumeRoute", "{}")->status, 404);
  EXPECT_EQ(Json(navigation + "CancelRoute", "{}")->status, 404);
}

TEST_F(ConnectServicesTest, ZonesArePutListedAndRemoved) {
  Start();
  const std::string navigation = kNavigation;
  const auto put = [&](const std::string& zone) {
    return Json(navigation + "PutZones", "{\"zones\":[" + zone + "]}");
  };
  const std::string corners =
      R"("corners":[{"xM":0,"yM":0},{"xM":1,"yM":0},{"xM":1,"yM":1}])";
  auto answer = put(R"({"name":"slow","kind":"ZONE_KIND_SPEED","maxMps":0.2,)" +
                    corners + "}");
  ASSERT_EQ(answer->status, 200) << answer->body;
  EXPECT_THAT(answer->body, HasSubstr("\"revision\":\"2\""));
  answer = Json(navigation + "GetZones", "{}");
  EXPECT_THAT(answer->body, HasSubstr("\"name\":\"slow\""));
  EXPECT_THAT(answer->body, HasSubstr("\"maxMps\":0.2"));
  // A kind that there is not, and a corner that is none.
  answer = put(R"({"name":"x",)" + corners + "}");
  EXPECT_EQ(answer->status, 400);
  EXPECT_THAT(answer->body, HasSubstr("kind"));
  answer = put(
      R"({"name":"x","kind":"ZONE_KIND_KEEP_OUT","corners":[{"xM":"NaN"},{},{}]})");
  EXPECT_EQ(answer->status, 400);
  EXPECT_THAT(answer->body, HasSubstr("corner 1"));
  EXPECT_EQ(Json(navigation + "PutZones", "{}")->status, 400);
  EXPECT_EQ(
      Json(navigation + "RemoveZones", R"({"names":["slow","x"]})")->status,
      404);
  EXPECT_EQ(Json(navigation + "RemoveZones", R"({"names":["slow"]})")->status,
            200);
  EXPECT_THAT(Json(navigation + "GetZones", "{}")->body,
              testing::Not(HasSubstr("slow")));
}

TEST_F(ConnectServicesTest, BinaryCallsAreAnsweredInBinary) {
  Start();
  const auto answer = Client().Post(std::string(kNavigation) + "GetInfo",
                                    kVersion, "", "application/proto");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->get_header_value("Content-Type"), "application/proto");
  v1::GetInfoResponse info;
  ASSERT_TRUE(info.ParseFromString(answer->body));
  EXPECT_EQ(info.version(), "1.2.3");
  EXPECT_EQ(info.levels_size(), 2);
  EXPECT_TRUE(info.simulated());
  EXPECT_THAT(info.places(), ElementsAre("kitchen"));
}

TEST_F(ConnectServicesTest, PagesOfOthersCannotCommand) {
  Start();
  const std::string path = std::string(kNavigation) + "Pause";
  // What a page of another origin can send without a preflight.
  EXPECT_EQ(Client().Post(path, "{}", "text/plain")->status, 415);
  EXPECT_EQ(Client().Post(path, "{}", "application/json")->status, 400);
  const auto preflight = Client().Options(path);
  EXPECT_EQ(preflight->status, 405);
  EXPECT_FALSE(preflight->has_header("Access-Control-Allow-Origin"));
  EXPECT_EQ(Client().Get(path)->status, 404);
  agent_->Close();
  EXPECT_EQ(agent_->navigator.mode(), behavior::NavigatorMode::kIdle);
}

TEST_F(ConnectServicesTest, ARealRobotHasNoSimulation) {
  Start(/*is_simulated=*/false);
  const auto answer = Json(std::string(kSimulation) + "Kidnap", "{}");
  EXPECT_EQ(answer->status, 404);
  EXPECT_THAT(answer->body, HasSubstr("unimplemented"));
}

}  // namespace
}  // namespace treeline::agent_service

#include "nav_agent/service/http_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/http/http_server.h"
#include "nav_agent/service/map_pictures.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

const httplib::Headers kOurs = {{"X-Treeline", "1"}};

class HttpApiTest : public ::testing::Test {
 protected:
  void Start(bool is_simulated = true) {
    agent_ = std::make_unique<SteppingAgent>(is_simulated);
    api_ = std::make_unique<HttpApi>(agent_->commands, metrics_, &camera_,
                                     nullptr, options_, clock_);
    auto server = http::HttpServer::Start(http_, *api_, clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  ~HttpApiTest() override {
    if (agent_ != nullptr) agent_->Close();
  }
  httplib::Client Client() const {
    return httplib::Client("http://" + server_->address());
  }
  httplib::Result Post(const std::string& path, const std::string& body) const {
    return Client().Post(path, kOurs, body, "application/json");
  }

  const base::SteadyClock clock_{};
  AgentMetrics metrics_;
  PictureKeeper camera_{std::chrono::milliseconds(0)};
  HttpApiOptions options_;
  http::HttpServerOptions http_{.listen = "127.0.0.1:0", .max_body_mib = 1};
  std::unique_ptr<SteppingAgent> agent_;
  std::unique_ptr<HttpApi> api_;
  std::unique_ptr<http::HttpServer> server_;
};

TEST_F(HttpApiTest, AGoalIsDrivenTo) {
  Start();
  const auto sent =
      Post("/api/goal", R"({"poses":[{"x":1,"y":1,"yaw":0,"level":0}]})");
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->status, 200);
  EXPECT_EQ(sent->body, R"({"ok":true,"id":1})");
  std::vector<std::string> events;
  std::string rest;
  Json last;
  Client().Get("/api/stream", [&](const char* data, size_t size) {
    rest.append(data, size);
    size_t end = 0;
    while ((end = rest.find("\n\n")) != std::string::npos) {
      const std::string one = rest.substr(0, end);
      rest.erase(0, end + 2);
      if (one.rfind("event: state\ndata: ", 0) != 0) continue;
      last = Json::parse(one.substr(one.find("data: ") + 6));
    }
    return last.is_null() || last["goal"]["state"] != "succeeded";
  });
  EXPECT_EQ(last["goal"]["poses"][0]["x"], 1.0);
  EXPECT_EQ(last["pose"]["x"], 1.0);
}

TEST_F(HttpApiTest, TheStreamHasStatesScenesAndEvents) {
  Start();
  agent_->hub.AddEvent(1.5, "plan", "a path of 3 m");
  std::string all;
  const auto result =
      Client().Get("/api/stream", [&](const char* data, size_t size) {
        all.append(data, size);
        return all.find("event: scene") == std::string::npos ||
               all.find("event: event") == std::string::npos;
      });
  EXPECT_THAT(all,
              HasSubstr("retry: 1000\n\nevent: state\ndata: {\"time_s\":"));
  EXPECT_THAT(all, HasSubstr("event: event\ndata: {\"number\":1,\"time_s\":1.5,"
                             "\"kind\":\"plan\",\"text\":\"a path of 3 m\"}"));
}

TEST_F(HttpApiTest, AStreamEndsWithTheAgent) {
  Start();
  std::atomic<bool> is_open = false;
  std::jthread reader([&] {
    Client().Get("/api/stream", [&](const char*, size_t) {
      is_open = true;
      return true;
    });
  });
  while (!is_open) std::this_thread::yield();
  agent_->Close();
}

TEST_F(HttpApiTest, StreamsAreBoundedAndFreedAgain) {
  options_.max_streams = 1;
  Start();
  std::atomic<bool> is_open = false;
  std::atomic<bool> may_go = false;
  {
    std::jthread first([&] {
      Client().Get("/api/stream", [&](const char*, size_t) {
        is_open = true;
        return !may_go.load();
      });
    });
    while (!is_open) std::this_thread::yield();
    const auto second = Client().Get("/api/stream");
    ASSERT_TRUE(second);
    EXPECT_EQ(second->status, 503);
    EXPECT_THAT(second->body, HasSubstr("resource_exhausted"));
    may_go = true;
  }
  // The one that vanished is noticed by the next state that is sent to it.
  int status = 503;
  while (status == 503) {
    Client().Get(
        "/api/stream",
        [&](const httplib::Response& response) {
          status = response.status;
          return status == 503;
        },
        [](const char*, size_t) { return true; });
  }
  EXPECT_EQ(status, 200);
}

TEST_F(HttpApiTest, ServesInfoStateAndScene) {
  Start();
  const auto info = Client().Get("/api/info");
  ASSERT_TRUE(info);
  EXPECT_EQ(Json::parse(info->body)["map"]["levels"].size(), 2U);
  // The first state is there once a command was run.
  ASSERT_EQ(Post("/api/resume", "{}")->status, 200);
  ASSERT_NE(agent_->hub.WaitForNewer(0, absl::InfiniteFuture()), nullptr);
  EXPECT_EQ(Json::parse(Client().Get("/api/state")->body)["mode"], "idle");
  EXPECT_TRUE(
      Json::parse(Client().Get("/api/scene")->body).contains("obstacles"));
}

TEST_F(HttpApiTest, ServesTheMap) {
  Start();
  const auto level = Client().Get("/api/levels/1.png");
  ASSERT_TRUE(level);
  EXPECT_EQ(level->get_header_value("Content-Type"), "image/png");
  EXPECT_EQ(level->body.substr(1, 3), "PNG");
  EXPECT_EQ(Client().Get("/api/levels/1.png")->body, level->body);
  EXPECT_EQ(Client().Get("/api/octomap")->body.substr(0, 4), "TLVX");
  const auto heights = Client().Get("/api/levels/1.heights");
  EXPECT_EQ(heights->get_header_value("Content-Type"),
            "application/octet-stream");
  EXPECT_EQ(heights->body, LevelHeights(agent_->info.map->levels.levels[1]));
}

TEST_F(HttpApiTest, OnlyANumberOfALevelNamesOne) {
  Start();
  for (const std::string name :
       {"2", "-1", "-0", "+1", "%201", "1%20", "x", "0x1", "1e0", "1.0", "",
        "99999", "99999999999999999999999", "4294967297", "..%2f1", "1%00",
        "%31%0a"}) {
    for (const char* ending : {".png", ".heights", ".PNG", "", "/"}) {
      const std::string path = "/api/levels/" + name + ending;
      const auto answer = Client().Get(path);
      ASSERT_TRUE(answer) << path;
      EXPECT_GE(answer->status, 400) << path;
      EXPECT_LE(answer->status, 404) << path;
    }
  }
  EXPECT_EQ(Client().Get("/api/levels/1")->status, 404);
  EXPECT_EQ(Client().Get("/api/levels/0.heights.png")->status, 404);
}

TEST_F(HttpApiTest, ServesPicturesOfTheCamera) {
  Start();
  EXPECT_EQ(Client().Get("/api/camera.jpg")->status, 404);
  EXPECT_EQ(Client().Get("/api/query.jpg")->status, 404);
  core::RgbdFrame frame;
  frame.frame.color = {
      .width = 8, .height = 8, .rgb = std::vector<uint8_t>(192, 9)};
  camera_.Keep(frame);
  const auto picture = Client().Get("/api/camera.jpg");
  EXPECT_EQ(picture->status, 200);
  EXPECT_EQ(picture->get_header_value("Content-Type"), "image/jpeg");
}

TEST_F(HttpApiTest, PagesOfOthersCannotCommand) {
  Start();
  const std::string body = R"({"poses":[{"x":1,"y":1}]})";
  EXPECT_EQ(Client().Post("/api/goal", body, "application/json")->status, 403);
  EXPECT_EQ(Client().Post("/api/goal", kOurs, body, "text/plain")->status, 415);
  const auto preflight = Client().Options("/api/goal");
  EXPECT_EQ(preflight->status, 405);
  EXPECT_FALSE(preflight->has_header("Access-Control-Allow-Origin"));
  EXPECT_EQ(Client().Put("/api/goal", body, "application/json")->status, 405);
  EXPECT_EQ(Client().Get("/api/goal")->status, 404);
  agent_->Close();
  EXPECT_FALSE(agent_->navigator.goal().has_value());
}

TEST_F(HttpApiTest, SaysWhatIsWrong) {
  Start();
  struct Case {
    const char* path;
    const char* body;
    int status;
    const char* says;
  };
  const Case cases[] = {
      {"/api/goal", "{", 400, "not JSON"},
      {"/api/goal", R"({"poses":[{"x":1,"y":1,"level":7}]})", 400, "0..1"},
      {"/api/cancel", "{}", 404, "goal 0 is not driven to"},
      {"/api/sim/kidnap", R"({"place":"moon"})", 404, "there are: kitchen"},
      {"/api/sim/remove-obstacle", R"({"name":"x"})", 404, "no such obstacle"},
      {"/api/no-such", "{}", 404, "no such call"},
  };
  for (const Case& one : cases) {
    const auto answer = Post(one.path, one.body);
    ASSERT_TRUE(answer) << one.path;
    EXPECT_EQ(answer->status, one.status) << one.path;
    EXPECT_THAT(std::string(Json::parse(answer->body)["error"]["message"]),
                HasSubstr(one.says))
        << one.path;
  }
  EXPECT_EQ(Post("/api/goal", std::string(2 << 20, ' '))->status, 413);
}

TEST_F(HttpApiTest, CommandsReachRobotAndSimulation) {
  Start();
  EXPECT_EQ(Post("/api/pause", "{}")->status, 200);
  EXPECT_EQ(Post("/api/find-yourself", "{}")->status, 200);
  EXPECT_EQ(Post("/api/initial-pose", R"({"x":1,"y":0.5,"yaw":0.1,"level":0})")
                ->status,
            200);
  EXPECT_EQ(Post("/api/sim/kidnap", "{}")->status, 200);
  EXPECT_EQ(Post("/api/sim/obstacle", R"({"x":1,"y":1,"level":0,"size_m":0.4})")
                ->body,
            R"({"ok":true,"name":"box-1"})");
  EXPECT_EQ(Post("/api/sim/fault",
                 R"({"target":"laser","kind":"silent","duration_s":3})")
                ->status,
            200);
  agent_->Close();
  EXPECT_EQ(agent_->navigator.mode(), behavior::NavigatorMode::kRelocalizing);
  EXPECT_EQ(agent_->navigator.snapshot.pose->pose.map_from_base.yaw_rad, 0.1);
  EXPECT_THAT(agent_->simulation.calls,
              ElementsAre("kidnap anywhere", "obstacle of 0.4 on 0",
                          "fault laser silent 3 1"));
}

TEST_F(HttpApiTest, ARealRobotHasNoSimulation) {
  Start(/*is_simulated=*/false);
  const auto answer = Post("/api/sim/kidnap", "{}");
  EXPECT_EQ(answer->status, 404);
  EXPECT_THAT(answer->body, HasSubstr("the robot is real"));
}

TEST_F(HttpApiTest, TellsHealthAndMetrics) {
  Start();
  EXPECT_EQ(Client().Get("/healthz")->status, 200);
  EXPECT_EQ(Client().Get("/readyz")->status, 200);
  EXPECT_THAT(Client().Get("/metrics")->body,
              HasSubstr("# TYPE treeline_agent_step_seconds histogram"));
  agent_->Close();
  EXPECT_EQ(Client().Get("/readyz")->status, 503);
  EXPECT_EQ(Client().Get("/healthz")->status, 200);
  EXPECT_EQ(Post("/api/pause", "{}")->status, 503);
}

// Pages that hold their streams do not make a robot look dead.
TEST_F(HttpApiTest, ProbesAreAnsweredWhereStreamsTakeAllConnections) {
  http_.max_connections = 1;
  http_.max_probe_connections = 1;
  Start();
  bool has_asked = false;
  Client().Get("/api/stream", [&](const char* /*data*/, size_t /*size*/) {
    for (const char* path : {"/healthz", "/readyz"}) {
      // The connection of the last probe may not be gone yet.
      auto answer = Client().Get(path);
      while (!answer) answer = Client().Get(path);
      EXPECT_EQ(answer->status, 200) << path;
    }
    const auto state = Client().Get("/api/state");
    EXPECT_TRUE(!state || state->status == 503);
    has_asked = true;
    return false;
  });
  EXPECT_TRUE(has_asked);
}

TEST_F(HttpApiTest, ServesThePage) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "http_api_page";
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(
      base::WriteFileAtomically((folder / "index.html").string(), "<p>").ok());
  options_.page_folder = folder.string();
  Start();
  const auto page = Client().Get("/");
  EXPECT_EQ(page->body, "<p>");
  const std::string policy = page->get_header_value("Content-Security-Policy");
  EXPECT_THAT(policy, HasSubstr("default-src 'self'"));
  EXPECT_THAT(policy, Not(HasSubstr("unsafe")));
  EXPECT_EQ(page->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(Client().Get("/%2e%2e/%2e%2e/etc/passwd")->status, 404);
  EXPECT_EQ(Client().Get("/..%2f..%2fetc/passwd")->status, 404);
  EXPECT_EQ(Client().Get("/nothing.js")->status, 404);
}

TEST_F(HttpApiTest, WithoutAPageItSaysSo) {
  Start();
  const auto page = Client().Get("/");
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->body, HasSubstr("not built"));
}

}  // namespace
}  // namespace treeline::agent_service

// Where tokens go, with a server on a real socket.
#include "client/cli/metrics_source.h"

#include <httplib.h>

#include <cstdlib>
#include <string>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::client_cli {
namespace {

using ::testing::HasSubstr;

constexpr char kToken[] = "TREELINE_TEST_TOKEN";

class MetricsSourceTest : public testing::Test {
 protected:
  MetricsSourceTest() {
    setenv(kToken, "secret", 1);
    server_.set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
          seen_ += request.get_header_value("Authorization") + " of " +
                   request.target + "\n";
          response.set_content("up 1\n", "text/plain");
          return httplib::Server::HandlerResponse::Handled;
        });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~MetricsSourceTest() override {
    unsetenv(kToken);
    unsetenv("http_proxy");
    Stop();
  }
  void Stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }
  std::string Address() const { return "127.0.0.1:" + std::to_string(port_); }

  static absl::Status StatusOf(const std::string& url,
                               const std::string& variable = "") {
    return MetricsSource::Open(url, {.token_variable = variable}).status();
  }

  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
  std::string seen_;
};

TEST_F(MetricsSourceTest, FetchesWithAToken) {
  const auto source =
      MetricsSource::Open("http://" + Address(), {.token_variable = kToken});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ(source->url(), "http://" + Address() + "/metrics");
  EXPECT_EQ(source->Fetch().value(), "up 1\n");
  const auto other = MetricsSource::Open("http://" + Address() + "/other", {});
  EXPECT_EQ(other->Fetch().value(), "up 1\n");
  Stop();
  EXPECT_EQ(seen_, "Bearer secret of /metrics\n of /other\n");
}

TEST_F(MetricsSourceTest, RefusesWhatIsNoAddress) {
  for (const char* url :
       {"127.0.0.1:80", "ftp://127.0.0.1", "http://", "http:///metrics",
        "http://127.0.0.1:80@robot/metrics", "http://127.0.0.1@robot",
        "http://127.0.0.1?@robot/", "http://127.0.0.1#@robot/",
        "http://127.0.0.1:80\\@robot/", "http://127.0.0.1:80,robot:80"}) {
    EXPECT_THAT(std::string(StatusOf(url).message()),
                HasSubstr("is no address of metrics"))
        << url;
  }
}

TEST_F(MetricsSourceTest, ATokenDoesNotLeaveTheMachineInTheClear) {
  for (const char* url :
       {"http://robot:80", "http://unix:80", "http://127.evil.org/metrics"}) {
    EXPECT_TRUE(StatusOf(url).ok()) << url;
    EXPECT_THAT(std::string(StatusOf(url, kToken).message()),
                HasSubstr("in the clear"))
        << url;
  }
  for (const char* url : {"https://robot:80", "http://[::1]:80/metrics",
                          "http://localhost", "http://127.0.0.1:80"}) {
    EXPECT_TRUE(StatusOf(url, kToken).ok()) << url;
  }
  EXPECT_EQ(StatusOf("http://127.0.0.1:1", "TREELINE_NO_TOKEN").code(),
            absl::StatusCode::kNotFound);
}

TEST_F(MetricsSourceTest, ATokenInTheClearPassesNoProxy) {
  setenv("http_proxy", Address().c_str(), 1);
  // Nobody is there but the proxy.
  const auto with =
      MetricsSource::Open("http://127.0.0.1:1", {.token_variable = kToken});
  EXPECT_EQ(with->Fetch().status().code(), absl::StatusCode::kUnavailable);
  const auto without = MetricsSource::Open("http://127.0.0.1:1", {});
  EXPECT_TRUE(without->Fetch().ok());
  Stop();
  EXPECT_EQ(seen_, " of http://127.0.0.1:1/metrics\n");
}

}  // namespace
}  // namespace treeline::client_cli

#include "client/scrape/http_get.h"

#include <httplib.h>

#include <string>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::scrape {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class HttpGetTest : public testing::Test {
 protected:
  HttpGetTest() {
    server_.Get("/metrics", [](const httplib::Request& request,
                               httplib::Response& response) {
      if (request.get_header_value("Authorization") != "Bearer secret") {
        response.status = 401;
        return;
      }
      response.set_content("up 1\n", "text/plain");
    });
    server_.Get("/large",
                [](const httplib::Request&, httplib::Response& response) {
                  response.set_content(std::string((size_t{8} << 20) + 1, 'x'),
                                       "text/plain");
                });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~HttpGetTest() override {
    server_.stop();
    thread_.join();
  }

  std::string Url(const std::string& path) const {
    return "http://127.0.0.1:" + std::to_string(port_) + path;
  }

  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
};

TEST_F(HttpGetTest, FetchesWithAToken) {
  const auto body = HttpGet(Url("/metrics"), {.bearer_token = "secret"});
  ASSERT_TRUE(body.ok()) << body.status();
  EXPECT_EQ(*body, "up 1\n");
}

TEST_F(HttpGetTest, NamesAddressAndReason) {
  const absl::Status no_token = HttpGet(Url("/metrics"), {}).status();
  EXPECT_EQ(no_token.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(std::string(no_token.message()),
              AllOf(HasSubstr("/metrics"), HasSubstr("token")));
  EXPECT_EQ(HttpGet(Url("/nothing"), {}).status().code(),
            absl::StatusCode::kNotFound);
  const absl::Status large = HttpGet(Url("/large"), {}).status();
  EXPECT_EQ(large.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(large.message()), HasSubstr("8 MiB"));
  EXPECT_EQ(HttpGet("file:///etc/hostname", {}).status().code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(HttpGet("http://127.0.0.1:1/", {}).status().code(),
            absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace treeline::scrape

// For tests: an HTTP server whose handler echoes.
#ifndef COMMON_HTTP_TESTING_HTTP_SERVER_H_
#define COMMON_HTTP_TESTING_HTTP_SERVER_H_

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/notification.h"
#include "common/base/clock.h"
#include "common/http/http_server.h"
#include "common/http/testing_raw_client.h"

namespace treeline::http {

// Echoes bodies of POST; GET /wait waits until it may go on.
class EchoHandler final : public HttpHandler {
 public:
  std::optional<HttpResponse> CheckHead(const HttpRequest& request) override {
    if (request.path == "/early") return HttpResponse{.status = 404};
    return std::nullopt;
  }
  std::optional<HttpResponse> Admit(HttpRequest& request) override {
    ++admitted;
    if (request.path == "/denied") return HttpResponse{.status = 401};
    request.client = "robot-7";
    return std::nullopt;
  }
  bool IsProbe(const HttpRequest& request) const override {
    return request.path == "/probe";
  }
  HttpResponse Handle(const HttpRequest& request) override {
    ++handled;
    if (request.path == "/client") {
      return {.content_type = "text/plain",
              .body = request.client.value_or("nobody")};
    }
    if (request.path == "/wait") {
      waiting.Notify();
      go_on.WaitForNotification();
    }
    if (request.path == "/stream") {
      return {.content_type = "text/plain",
              .stream = [this](HttpBodyWriter& writer) {
                for (int i = 0; i < 3; ++i) {
                  if (!writer.Write(absl::StrCat("part ", i, "\n"))) break;
                }
                while (endless && writer.Write(std::string(65536, 'x'))) {
                }
                streamed.Notify();
              }};
    }
    if (request.path == "/throw") throw std::bad_alloc();
    if (request.path == "/large") {
      return {.content_type = "text/plain", .body = std::string(1 << 25, 'x')};
    }
    return {.content_type = "text/plain", .body = request.body};
  }
  HttpResponse Error(int status) override {
    return {.status = status,
            .content_type = "text/plain",
            .body = absl::StrCat("error ", status)};
  }
  std::vector<std::pair<std::string, std::string>> CommonHeaders(
      const HttpRequest& /*request*/) override {
    return {{"X-Common", "yes"}};
  }

  std::atomic<int> admitted = 0;
  std::atomic<int> handled = 0;
  std::atomic<bool> endless = false;
  absl::Notification streamed;
  absl::Notification waiting;
  absl::Notification go_on;
};

class HttpServerTest : public ::testing::Test {
 protected:
  HttpServerTest() {
    options_.listen = "127.0.0.1:0";
    options_.max_body_mib = 1;
  }

  void Start() {
    auto server = HttpServer::Start(options_, handler_, clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  // Sends bytes and reads until the server closes.
  std::string Exchange(absl::string_view bytes) const {
    const RawClient client(server_->address());
    EXPECT_TRUE(client.Send(bytes));
    return client.ReadAll();
  }

  const base::SteadyClock clock_{};
  HttpServerOptions options_;
  EchoHandler handler_;
  std::unique_ptr<HttpServer> server_;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_TESTING_HTTP_SERVER_H_

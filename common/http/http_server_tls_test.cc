// The server over TLS.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "common/base/listen_address.h"
#include "common/http/http_server.h"
#include "common/http/testing_raw_client.h"
#include "common/http/testing_tls.h"

namespace treeline::http {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class NamesHandler final : public HttpHandler {
 public:
  std::optional<HttpResponse> CheckHead(const HttpRequest&) override {
    return std::nullopt;
  }
  HttpResponse Handle(const HttpRequest& request) override {
    names = request.certificate_names;
    return {.content_type = "text/plain", .body = request.body};
  }
  HttpResponse Error(int status) override { return {.status = status}; }
  std::vector<std::pair<std::string, std::string>> CommonHeaders(
      const HttpRequest&) override {
    return {};
  }

  std::vector<std::string> names;
};

class HttpServerTlsTest : public ::testing::Test {
 protected:
  HttpServerTlsTest() {
    options_.listen = "127.0.0.1:0";
    options_.tls = ServerTls{
        .configure =
            [this](SSL_CTX& context) {
              return certificate_.Configure(context);
            },
        .client_names = [](SSL*) { return std::vector<std::string>{"robot"}; }};
  }

  void Start() {
    auto server = HttpServer::Start(options_, handler_, clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    client_ = std::make_unique<httplib::SSLClient>(
        "127.0.0.1", base::ParseListenAddress(server_->address())->port);
    client_->enable_server_certificate_verification(false);
    client_->set_tcp_nodelay(true);
    client_->set_keep_alive(true);
  }

  const SelfSigned certificate_{};
  const base::SteadyClock clock_{};
  HttpServerOptions options_;
  NamesHandler handler_;
  std::unique_ptr<HttpServer> server_;
  std::unique_ptr<httplib::SSLClient> client_;
};

TEST_F(HttpServerTlsTest, CarriesLargeBodiesOnOneConnection) {
  Start();
  for (int i = 0; i < 3; ++i) {
    const std::string body(3 << 20, static_cast<char>('a' + i));
    const auto result = client_->Post("/", body, "text/plain");
    ASSERT_TRUE(result) << result.error();
    EXPECT_TRUE(result->body == body);
  }
}

TEST_F(HttpServerTlsTest, TellsTheNamesOfTheClientsCertificate) {
  Start();
  ASSERT_TRUE(client_->Get("/"));
  EXPECT_THAT(handler_.names, ElementsAre("robot"));
}

TEST_F(HttpServerTlsTest, DoesNotAnswerWithoutEncryption) {
  options_.stream.head_timeout = std::chrono::milliseconds(200);
  Start();
  httplib::Client plain("http://" + server_->address());
  EXPECT_FALSE(plain.Get("/"));
}

TEST_F(HttpServerTlsTest, EndsHandshakesThatNeverCome) {
  options_.stream.head_timeout = std::chrono::milliseconds(50);
  Start();
  const RawClient silent(server_->address());
  EXPECT_THAT(silent.ReadAll(), IsEmpty());
}

TEST_F(HttpServerTlsTest, NeedsNoPermissionForOtherMachines) {
  options_.listen = "0.0.0.0:0";
  Start();
  EXPECT_TRUE(client_->Get("/"));
}

TEST_F(HttpServerTlsTest, RefusesASetUpThatFails) {
  options_.tls->configure = [](SSL_CTX&) { return false; };
  EXPECT_EQ(HttpServer::Start(options_, handler_, clock_).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::http

// HTTP over TLS on real sockets, with certificates that are replaced.
#include "server/access/http_tls.h"

#include <httplib.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_join.h"
#include "gtest/gtest.h"
#include "tests/integration/tls_fixture.h"

namespace treeline {
namespace {

class HttpTlsTest : public TlsTest {
 protected:
  void Start(bool ask_clients = false, bool require = false) {
    Open(ask_clients, require);
    tls_ = std::make_unique<access::HttpTls>(*files_);
    server_ = std::make_unique<httplib::SSLServer>(
        [this](SSL_CTX& context) { return tls_->Configure(context); });
    ASSERT_TRUE(server_->is_valid());
    server_->Get("/names", [](const httplib::Request& request,
                              httplib::Response& response) {
      const std::string names =
          absl::StrJoin(access::CertificateNames(*request.ssl), ",");
      response.set_content(names.empty() ? "none" : names, "text/plain");
    });
    port_ = server_->bind_to_any_port("127.0.0.1");
    ASSERT_GT(port_, 0);
    thread_ = std::thread([this] { server_->listen_after_bind(); });
    while (!server_->is_running()) std::this_thread::yield();
  }
  void TearDown() override {
    server_->stop();
    thread_.join();
    server_.reset();
    TlsTest::TearDown();
  }

  // The client's names, "none", or "FAILED", over a connection of its own.
  std::string Ask(const access::MadeCertificate& trusted,
                  const std::string& certificate_path = "",
                  const std::string& key_path = "") const {
    httplib::SSLClient client("localhost", port_, certificate_path, key_path);
    client.set_ca_cert_path(
        PutFile(std::to_string(std::hash<std::string>{}(trusted.certificate)),
                trusted.certificate));
    const httplib::Result result = client.Get("/names");
    return result && result->status == 200 ? result->body : "FAILED";
  }
  std::string AskAs(const access::MadeCertificate& mine) const {
    return Ask(authority_, PutFile("mine.crt", mine.certificate),
               PutFile("mine.key", mine.key));
  }

  std::unique_ptr<access::HttpTls> tls_;
  std::unique_ptr<httplib::SSLServer> server_;
  int port_ = 0;
  std::thread thread_;
};

TEST_F(HttpTlsTest, ShowsNewConnectionsTheNewCertificate) {
  Start();
  EXPECT_EQ(Ask(authority_), "none");
  EXPECT_EQ(Ask(stranger_), "FAILED");
  Rotate(ServerCertificate(stranger_));
  EXPECT_EQ(Ask(authority_), "FAILED");
  EXPECT_EQ(Ask(stranger_), "none");
}

TEST_F(HttpTlsTest, FailsNoRequestWhileCertificatesRotate) {
  Start();
  const std::string both =
      PutFile("both.crt", authority_.certificate + stranger_.certificate);
  std::atomic<bool> stop = false;
  std::atomic<int> requests = 0;
  std::atomic<int> failures = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&] {
      while (!stop) {
        httplib::SSLClient client("localhost", port_);
        client.set_ca_cert_path(both);
        const httplib::Result result = client.Get("/names");
        if (!result || result->body != "none") ++failures;
        ++requests;
      }
    });
  }
  for (int i = 0; i < 10; ++i) {
    const int before = requests;
    Rotate(ServerCertificate(i % 2 == 0 ? stranger_ : authority_));
    while (requests < before + 12) std::this_thread::yield();
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failures, 0) << "of " << requests << " requests";
}

TEST_F(HttpTlsTest, RecoversFromAnExpiredCertificateWithoutARestart) {
  const access::MadeCertificate expired = ServerCertificate(authority_, -10);
  PutFile("tls.crt", expired.certificate);
  PutFile("tls.key", expired.key);
  Start();
  EXPECT_EQ(Ask(authority_), "FAILED");
  Rotate(ServerCertificate(authority_));
  EXPECT_EQ(Ask(authority_), "none");
}

TEST_F(HttpTlsTest, TurnsAwayClientsWithoutTheCertificateThatItRequires) {
  Start(/*ask_clients=*/true, /*require=*/true);
  EXPECT_EQ(Ask(authority_), "FAILED");
  EXPECT_EQ(AskAs(access::MakeCertificate(stranger_, {.common_name = "x"})),
            "FAILED");
  EXPECT_EQ(AskAs(access::MakeCertificate(
                authority_, {.alternative_names =
                                 "DNS:robot.example,URI:spiffe://example/r"})),
            "robot.example,spiffe://example/r");
  PutFile("clients.crt", stranger_.certificate);
  NextPoll();
  EXPECT_EQ(AskAs(access::MakeCertificate(stranger_, {.common_name = "x"})),
            "x");
  EXPECT_EQ(AskAs(access::MakeCertificate(authority_, {.common_name = "x"})),
            "FAILED");
}

TEST_F(HttpTlsTest, CanLeaveTheCertificateToTheClient) {
  Start(/*ask_clients=*/true);
  EXPECT_EQ(Ask(authority_), "none");
  EXPECT_EQ(AskAs(access::MakeCertificate(authority_, {.common_name = "x"})),
            "x");
  EXPECT_EQ(AskAs(access::MakeCertificate(stranger_, {.common_name = "x"})),
            "FAILED");
}

TEST_F(HttpTlsTest, SpeaksTls12AndNewerOnly) {
  Start();
  EXPECT_TRUE(SpeaksTls(port_, TLS1_3_VERSION));
  EXPECT_TRUE(SpeaksTls(port_, TLS1_2_VERSION));
  EXPECT_FALSE(SpeaksTls(port_, TLS1_1_VERSION));
}

}  // namespace
}  // namespace treeline

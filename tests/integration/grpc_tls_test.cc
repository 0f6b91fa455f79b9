// gRPC over TLS on real sockets: certificates that rotate, expire, or are not
// what the other side trusts.
#include "server/access/grpc_tls.h"

#include <grpcpp/grpcpp.h>
#include <openssl/ssl.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "gtest/gtest.h"
#include "tests/integration/tls_fixture.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline {
namespace {

// Answers with the names in the client's certificate.
class EchoNames final : public v1::SceneService::Service {
 public:
  grpc::Status GetScene(grpc::ServerContext* context,
                        const v1::GetSceneRequest* /*request*/,
                        v1::GetSceneResponse* response) override {
    response->mutable_scene()->set_scene(
        absl::StrJoin(access::CertificateNames(*context->auth_context()), ","));
    return grpc::Status::OK;
  }
};

class GrpcTlsTest : public TlsTest {
 protected:
  void Start(bool ask_clients = false, bool require = false) {
    Open(ask_clients, require);
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0",
                             access::MakeServerCredentials(*files_), &port_);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    ASSERT_NE(server_, nullptr);
    ASSERT_NE(port_, 0);
  }
  void TearDown() override {
    server_.reset();
    TlsTest::TearDown();
  }

  // A connection of its own.
  std::unique_ptr<v1::SceneService::Stub> Connect(
      const std::string& trusted,
      const access::MadeCertificate& mine = {}) const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return v1::SceneService::NewStub(grpc::CreateCustomChannel(
        absl::StrCat("localhost:", port_),
        grpc::SslCredentials({.pem_root_certs = trusted,
                              .pem_private_key = mine.key,
                              .pem_cert_chain = mine.certificate}),
        arguments));
  }

  // The client's names, "none", or "FAILED".
  static std::string Ask(v1::SceneService::Stub& stub) {
    grpc::ClientContext context;
    v1::GetSceneResponse response;
    const grpc::Status status = stub.GetScene(&context, {}, &response);
    if (!status.ok()) return "FAILED";
    return response.scene().scene().empty() ? "none" : response.scene().scene();
  }
  std::string AskAnew(const std::string& trusted,
                      const access::MadeCertificate& mine = {}) const {
    return Ask(*Connect(trusted, mine));
  }

  EchoNames service_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

TEST_F(GrpcTlsTest, ServesThoseWhoTrustItsAuthority) {
  Start();
  EXPECT_EQ(AskAnew(authority_.certificate), "none");
  EXPECT_EQ(AskAnew(stranger_.certificate), "FAILED");
}

TEST_F(GrpcTlsTest, SpeaksTls12AndNewerOnly) {
  Start();
  EXPECT_TRUE(SpeaksTls(port_, TLS1_3_VERSION));
  EXPECT_TRUE(SpeaksTls(port_, TLS1_2_VERSION));
  EXPECT_FALSE(SpeaksTls(port_, TLS1_1_VERSION));
}

TEST_F(GrpcTlsTest, FailsNoCallWhileCertificatesRotate) {
  Start();
  const std::string both = authority_.certificate + stranger_.certificate;
  std::atomic<bool> stop = false;
  std::atomic<int> calls = 0;
  std::atomic<int> failures = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      const auto kept = Connect(both);
      while (!stop) {
        const std::string answer = t == 0 ? Ask(*kept) : AskAnew(both);
        if (answer != "none") ++failures;
        ++calls;
      }
    });
  }
  for (int i = 0; i < 10; ++i) {
    const int before = calls;
    Rotate(ServerCertificate(i % 2 == 0 ? stranger_ : authority_));
    while (calls < before + 12) std::this_thread::yield();
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failures, 0) << "of " << calls << " calls";
}

TEST_F(GrpcTlsTest, ShowsNewConnectionsTheNewCertificateAndKeepsTheOldOnes) {
  Start();
  const auto kept = Connect(authority_.certificate);
  EXPECT_EQ(Ask(*kept), "none");
  Rotate(ServerCertificate(stranger_));
  EXPECT_EQ(AskAnew(stranger_.certificate), "none");
  EXPECT_EQ(AskAnew(authority_.certificate), "FAILED");
  EXPECT_EQ(Ask(*kept), "none");
}

TEST_F(GrpcTlsTest, RecoversFromAnExpiredCertificateWithoutARestart) {
  const access::MadeCertificate expired = ServerCertificate(authority_, -10);
  PutFile("tls.crt", expired.certificate);
  PutFile("tls.key", expired.key);
  Start();
  EXPECT_EQ(AskAnew(authority_.certificate), "FAILED");
  Rotate(ServerCertificate(authority_));
  EXPECT_EQ(AskAnew(authority_.certificate), "none");
}

TEST_F(GrpcTlsTest, TurnsAwayClientsWithoutTheCertificateThatItRequires) {
  Start(/*ask_clients=*/true, /*require=*/true);
  const std::string& trusted = authority_.certificate;
  const access::CertificateSpec spec = {
      .common_name = "ignored",
      .alternative_names =
          "DNS:robot-7.example,URI:spiffe://example/robot-7,IP:10.0.0.7"};
  EXPECT_EQ(AskAnew(trusted), "FAILED");
  EXPECT_EQ(AskAnew(trusted, access::MakeCertificate(stranger_, spec)),
            "FAILED");
  EXPECT_EQ(
      AskAnew(trusted, access::MakeCertificate(authority_, {.ends_s = -10})),
      "FAILED");
  EXPECT_EQ(AskAnew(trusted, access::MakeCertificate(authority_, spec)),
            "robot-7.example,spiffe://example/robot-7");
  EXPECT_EQ(AskAnew(trusted, access::MakeCertificate(authority_,
                                                     {.common_name = "robot"})),
            "robot");
}

TEST_F(GrpcTlsTest, CanLeaveTheCertificateToTheClient) {
  Start(/*ask_clients=*/true);
  const std::string& trusted = authority_.certificate;
  EXPECT_EQ(AskAnew(trusted), "none");
  EXPECT_EQ(AskAnew(trusted, access::MakeCertificate(authority_,
                                                     {.common_name = "robot"})),
            "robot");
  // A forged one is no better than it looks.
  EXPECT_EQ(AskAnew(trusted, access::MakeCertificate(stranger_,
                                                     {.common_name = "robot"})),
            "FAILED");
}

TEST_F(GrpcTlsTest, TrustsANewAuthorityOfClientsWithoutARestart) {
  Start(/*ask_clients=*/true, /*require=*/true);
  const std::string& trusted = authority_.certificate;
  const access::MadeCertificate mine =
      access::MakeCertificate(stranger_, {.common_name = "robot"});
  EXPECT_EQ(AskAnew(trusted, mine), "FAILED");
  PutFile("clients.crt", stranger_.certificate);
  NextPoll();
  EXPECT_EQ(AskAnew(trusted, mine), "robot");
  EXPECT_EQ(AskAnew(trusted, access::MakeCertificate(authority_,
                                                     {.common_name = "old"})),
            "FAILED");
}

TEST_F(GrpcTlsTest, AsksNobodyWhoNeedNotShowOne) {
  Start();
  EXPECT_EQ(
      AskAnew(authority_.certificate,
              access::MakeCertificate(authority_, {.common_name = "robot"})),
      "none");
}

}  // namespace
}  // namespace treeline

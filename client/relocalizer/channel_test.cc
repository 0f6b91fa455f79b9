// Connections against a server with TLS: who is trusted, and what is shown.
#include "client/relocalizer/channel.h"

#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "absl/synchronization/mutex.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "client/relocalizer/relocalizer.h"
#include "client/relocalizer/testing_certificates.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline::relocalizer {
namespace {

using ::testing::HasSubstr;
namespace pem = testing_certificates;

class SeeingService final : public v1::SceneService::Service {
 public:
  grpc::Status ListScenes(grpc::ServerContext* context,
                          const v1::ListScenesRequest*,
                          v1::ListScenesResponse*) override {
    absl::MutexLock lock(&mutex_);
    const auto& metadata = context->client_metadata();
    const auto at = metadata.find("authorization");
    authorization_ = at == metadata.end()
                         ? ""
                         : std::string(at->second.data(), at->second.size());
    const auto names =
        context->auth_context()->FindPropertyValues("x509_common_name");
    client_name_ =
        names.empty() ? "" : std::string(names[0].data(), names[0].size());
    return grpc::Status::OK;
  }
  std::string authorization() {
    absl::MutexLock lock(&mutex_);
    return authorization_;
  }
  std::string client_name() {
    absl::MutexLock lock(&mutex_);
    return client_name_;
  }

 private:
  absl::Mutex mutex_;
  std::string authorization_ ABSL_GUARDED_BY(mutex_);
  std::string client_name_ ABSL_GUARDED_BY(mutex_);
};

class ChannelTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override {
    server_->Shutdown();
    std::filesystem::remove_all(folder_);
  }

  // Returns the address.
  std::string StartServer(bool asks_for_certificate = false) {
    grpc::SslServerCredentialsOptions options(
        asks_for_certificate
            ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
            : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
    options.pem_root_certs = pem::kAuthority;
    options.pem_key_cert_pairs = {{pem::kServerKey, pem::kServer}};
    return Start(grpc::SslServerCredentials(options));
  }
  std::string Start(
      const std::shared_ptr<grpc::ServerCredentials>& credentials) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", credentials, &port);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    return "127.0.0.1:" + std::to_string(port);
  }

  std::string Put(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(base::WriteFileAtomically(folder_ + "/" + name, text).ok());
    return folder_ + "/" + name;
  }

  ConnectOptions Trusting(const std::string& server,
                          const char* authority = pem::kAuthority) const {
    return {.server = server,
            .max_attempts = 1,
            .tls = {.ca_file = Put("ca.pem", authority)},
            .own_connections = true};
  }

  static absl::Status Ask(const ConnectOptions& options) {
    const auto client = ConnectRelocalizer(options);
    if (!client.ok()) return client.status();
    return (*client)->ListScenes({}).status();
  }

  SeeingService service_;
  std::unique_ptr<grpc::Server> server_;
  const std::string folder_ =
      testing::TempDir() + "/channel-" + std::to_string(getpid());
};

TEST_F(ChannelTest, ATrustedServerIsAsked) {
  EXPECT_TRUE(Ask(Trusting(StartServer())).ok());
}

TEST_F(ChannelTest, AProxyIsNotAskedForThisMachine) {
  const ConnectOptions options = Trusting(StartServer());
  setenv("http_proxy", "http://127.0.0.1:1", 1);
  setenv("grpc_proxy", "http://127.0.0.1:1", 1);
  const absl::Status status = Ask(options);
  unsetenv("http_proxy");
  unsetenv("grpc_proxy");
  EXPECT_TRUE(status.ok()) << status;
}

TEST_F(ChannelTest, AServerOfAnotherAuthorityIsNot) {
  EXPECT_EQ(Ask(Trusting(StartServer(), pem::kOtherAuthority)).code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(ChannelTest, TheCertificateMustHaveTheName) {
  ConnectOptions options = Trusting(StartServer());
  options.tls.server_name = "treeline.test";
  EXPECT_TRUE(Ask(options).ok());
  options.tls.server_name = "elsewhere.test";
  EXPECT_EQ(Ask(options).code(), absl::StatusCode::kUnavailable);
}

TEST_F(ChannelTest, AListWithTlsIsOneName) {
  const std::string server = StartServer();
  EXPECT_TRUE(Ask(Trusting(server + "," + server)).ok());
  EXPECT_THAT(std::string(Ask(Trusting(server + ",127.0.0.2:1")).message()),
              HasSubstr("which name"));
}

TEST_F(ChannelTest, AClientShowsItsCertificate) {
  ConnectOptions options = Trusting(StartServer(/*asks_for_certificate=*/true));
  EXPECT_EQ(Ask(options).code(), absl::StatusCode::kUnavailable);
  options.tls.certificate_file = Put("client.pem", pem::kClient);
  options.tls.key_file = Put("client.key", pem::kClientKey);
  EXPECT_TRUE(Ask(options).ok());
  EXPECT_EQ(service_.client_name(), "client");
}

TEST_F(ChannelTest, EveryCallCarriesTheTokenAsItIsNow) {
  ConnectOptions options = Trusting(StartServer());
  options.token_file = Put("token", "first\n");
  const auto client = ConnectRelocalizer(options).value();
  ASSERT_TRUE(client->ListScenes({}).ok());
  EXPECT_EQ(service_.authorization(), "Bearer first");
  Put("token", "second\n");
  ASSERT_TRUE(client->ListScenes({}).ok());
  EXPECT_EQ(service_.authorization(), "Bearer second");
}

TEST_F(ChannelTest, TokensWithoutTlsStayOnThisMachine) {
  const std::string server = Start(grpc::InsecureServerCredentials());
  EXPECT_TRUE(Ask({.server = server, .token_file = Put("token", "abc")}).ok());
  EXPECT_EQ(service_.authorization(), "Bearer abc");
}

TEST_F(ChannelTest, FilesThatAreNoneAreNamedAtOnce) {
  ConnectOptions options = Trusting(StartServer(), "no certificate");
  EXPECT_THAT(std::string(Ask(options).message()), HasSubstr("ca.pem"));
  options.tls.ca_file = folder_ + "/none.pem";
  EXPECT_EQ(Ask(options).code(), absl::StatusCode::kNotFound);
  options = Trusting("127.0.0.1:1");
  options.token_file = folder_ + "/none";
  EXPECT_EQ(Ask(options).code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::relocalizer

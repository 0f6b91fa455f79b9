// A guarded gRPC server that is flooded, over TCP and over TLS.
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <memory>
#include <string>

#include "common/base/clock.h"
#include "common/base/descriptor.h"
#include "common/flood_guard/testing_connection.h"
#include "common/flood_guard/testing_frames.h"
#include "common/grpc_server/grpc_listener.h"

namespace treeline::grpc_server {
namespace {

using flood_guard::CutReason;
using flood_guard::kTestEndHeaders;
using flood_guard::kTestHeaders;
using flood_guard::kTestPreface;
using flood_guard::kTestReset;
using flood_guard::kTestSettings;
using flood_guard::TestFrame;

// A key and a certificate for localhost that it has signed itself, as PEM.
grpc::SslServerCredentialsOptions::PemKeyCertPair SelfSigned() {
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      EVP_EC_gen("P-256"), &EVP_PKEY_free);
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(X509_new(),
                                                                &X509_free);
  X509_set_version(certificate.get(), X509_VERSION_3);
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -60);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), 3600);
  X509_set_pubkey(certificate.get(), key.get());
  X509_sign(certificate.get(), key.get(), EVP_sha256());
  const std::unique_ptr<BIO, decltype(&BIO_free)> out(BIO_new(BIO_s_mem()),
                                                      &BIO_free);
  const auto taken = [&out] {
    const char* data = nullptr;
    const auto size = BIO_get_mem_data(out.get(), &data);
    std::string text(data, static_cast<size_t>(size));
    BIO_reset(out.get());
    return text;
  };
  PEM_write_bio_PrivateKey(out.get(), key.get(), nullptr, nullptr, 0, nullptr,
                           nullptr);
  grpc::SslServerCredentialsOptions::PemKeyCertPair pair;
  pair.private_key = taken();
  PEM_write_bio_X509(out.get(), certificate.get());
  pair.cert_chain = taken();
  return pair;
}

// Raw bytes to a server, over TLS where that is wanted.
class Attacker {
 public:
  Attacker(const std::string& address, bool tls)
      : socket_(flood_guard::ConnectForTest(address)) {
    EXPECT_GE(socket_.get(), 0);
    if (!tls) return;
    context_.reset(SSL_CTX_new(TLS_client_method()));
    ssl_.reset(SSL_new(context_.get()));
    static constexpr std::array<unsigned char, 3> kH2 = {2, 'h', '2'};
    SSL_set_alpn_protos(ssl_.get(), kH2.data(), kH2.size());
    SSL_set_fd(ssl_.get(), socket_.get());
    EXPECT_EQ(SSL_connect(ssl_.get()), 1);
  }

  // False: nobody takes it any more.
  bool Send(const std::string& bytes) {
    if (ssl_ != nullptr) {
      return SSL_write(ssl_.get(), bytes.data(),
                       static_cast<int>(bytes.size())) > 0;
    }
    return send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) > 0;
  }

  // Reads until the server closes the connection; false: it does not.
  bool WaitForTheEnd() {
    std::array<char, 4096> bytes = {};
    while (true) {
      const ssize_t size =
          ssl_ != nullptr ? SSL_read(ssl_.get(), bytes.data(), bytes.size())
                          : recv(socket_.get(), bytes.data(), bytes.size(), 0);
      if (size > 0) continue;
      return size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK);
    }
  }

 private:
  const base::Descriptor socket_;
  std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context_{nullptr,
                                                             &SSL_CTX_free};
  std::unique_ptr<SSL, decltype(&SSL_free)> ssl_{nullptr, &SSL_free};
};

// Calls that are reset at once. Three literals without a name in the table: no
// gRPC call, but gRPC learns that only when it has a stream.
std::string Resets(int from, int count) {
  std::string frames;
  for (int i = from; i < from + count; ++i) {
    frames += TestFrame(kTestHeaders, kTestEndHeaders, 2 * i + 1, "\x83\x86") +
              TestFrame(kTestReset, 0, 2 * i + 1, std::string(4, '\0'));
  }
  return frames;
}

class FloodTest : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    // OpenSSL writes to sockets that the server has closed.
    std::signal(SIGPIPE, SIG_IGN);
    GrpcListenerOptions options{.listen = "127.0.0.1:0", .guard = guard_};
    if (GetParam()) {
      grpc::SslServerCredentialsOptions tls;
      tls.pem_key_cert_pairs.push_back(SelfSigned());
      options.credentials = grpc::SslServerCredentials(tls);
    }
    auto started =
        StartGrpcListener(options, [this](grpc::ServerBuilder& builder) {
          builder.RegisterCallbackGenericService(&service_);
        });
    ASSERT_TRUE(started.ok()) << started.status();
    listener_ = std::move(*started);
  }
  void TearDown() override {
    listener_.server->Shutdown(std::chrono::system_clock::now());
  }

  const base::SteadyClock clock_{};
  const std::shared_ptr<flood_guard::FloodGuard> guard_ =
      std::make_shared<flood_guard::FloodGuard>(
          flood_guard::FloodLimits{.calls_per_s = 500}, clock_);
  grpc::CallbackGenericService service_;
  GrpcListener listener_;
};

TEST_P(FloodTest, WhoFloodsIsCutOff) {
  Attacker attacker(listener_.address, GetParam());
  ASSERT_TRUE(attacker.Send(kTestPreface + TestFrame(kTestSettings, 0, 0, "") +
                            TestFrame(kTestSettings, 1, 0, "")));
  for (int i = 0; i < 100 && attacker.Send(Resets(100 * i, 100)); ++i) {
  }
  EXPECT_TRUE(attacker.WaitForTheEnd());
  EXPECT_GE(guard_->cuts(CutReason::kCalls), 1u);
}

TEST_P(FloodTest, WhoStaysBelowTheLimitIsNot) {
  Attacker attacker(listener_.address, GetParam());
  ASSERT_TRUE(attacker.Send(kTestPreface + TestFrame(kTestSettings, 0, 0, "") +
                            TestFrame(kTestSettings, 1, 0, "") +
                            Resets(0, 200) +
                            // A frame that gRPC itself ends a connection for.
                            TestFrame(kTestSettings, 1, 0, "bad length")));
  EXPECT_TRUE(attacker.WaitForTheEnd());
  for (size_t i = 0; i < flood_guard::kCutReasons; ++i) {
    EXPECT_EQ(guard_->cuts(static_cast<CutReason>(i)), 0u) << i;
  }
}

TEST_P(FloodTest, HeadersWithoutEndAreCutOff) {
  Attacker attacker(listener_.address, GetParam());
  attacker.Send(kTestPreface + TestFrame(kTestSettings, 0, 0, "") +
                TestFrame(kTestHeaders, 0, 1, "\x83\x86"));
  const std::string more = TestFrame(flood_guard::kTestContinuation, 0, 1,
                                     std::string(8000, '\x83'));
  for (int i = 0; i < 50 && attacker.Send(more); ++i) {
  }
  EXPECT_TRUE(attacker.WaitForTheEnd());
  EXPECT_EQ(guard_->cuts(CutReason::kHeaderBlock), 1u);
}

INSTANTIATE_TEST_SUITE_P(TcpAndTls, FloodTest, ::testing::Bool());

// A service whose calls last until their client leaves.
class WaitingService final : public grpc::CallbackGenericService {
 public:
  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* /*context*/) override {
    class Waiting final : public grpc::ServerGenericBidiReactor {
      void OnCancel() override { Finish(grpc::Status::CANCELLED); }
      void OnDone() override { delete this; }
    };
    return new Waiting;
  }
};

TEST(OpenCalls, AreCountedByAddress) {
  const base::SteadyClock clock;
  const auto guard = std::make_shared<flood_guard::FloodGuard>(
      flood_guard::FloodLimits{.calls_per_s = 10000, .open_calls = 20}, clock);
  WaitingService service;
  auto listener =
      StartGrpcListener({.listen = "127.0.0.1:0", .guard = guard},
                        [&](grpc::ServerBuilder& builder) {
                          builder.RegisterCallbackGenericService(&service);
                        });
  ASSERT_TRUE(listener.ok()) << listener.status();
  grpc::GenericStub stub(grpc::CreateChannel(
      listener->address, grpc::InsecureChannelCredentials()));
  grpc::CompletionQueue queue;
  // One after the other, so that each is open before the next begins. The
  // first that is too many cuts the connection, which ends all of them.
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream;
  };
  std::vector<std::unique_ptr<Call>> calls;
  const auto deadline =
      std::chrono::system_clock::now() + std::chrono::seconds(60);
  while (guard->cuts(CutReason::kOpenCalls) == 0 &&
         std::chrono::system_clock::now() < deadline) {
    auto call = std::make_unique<Call>();
    call->stream = stub.PrepareCall(&call->context, "/any/Method", &queue);
    call->stream->StartCall(nullptr);
    calls.push_back(std::move(call));
    void* tag = nullptr;
    bool ok = false;
    ASSERT_TRUE(queue.Next(&tag, &ok));
  }
  EXPECT_EQ(guard->cuts(CutReason::kOpenCalls), 1u);
  EXPECT_GT(calls.size(), 20u);
  for (const auto& call : calls) call->context.TryCancel();
  listener->server->Shutdown(std::chrono::system_clock::now());
  calls.clear();
  queue.Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue.Next(&tag, &ok)) {
  }
}

}  // namespace
}  // namespace treeline::grpc_server

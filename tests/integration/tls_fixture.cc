#include "tests/integration/tls_fixture.h"

#include <arpa/inet.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <utility>

#include "common/base/file.h"

namespace treeline {

void TlsTest::SetUp() {
  folder_ = testing::TempDir() + "/tls-" +
            testing::UnitTest::GetInstance()->current_test_info()->name();
  std::filesystem::create_directories(folder_);
  const access::MadeCertificate first = ServerCertificate(authority_);
  PutFile("tls.crt", first.certificate);
  PutFile("tls.key", first.key);
  PutFile("clients.crt", authority_.certificate);
}

void TlsTest::TearDown() { std::filesystem::remove_all(folder_); }

access::MadeCertificate TlsTest::ServerCertificate(
    const access::MadeCertificate& authority, int64_t ends_s) {
  return access::MakeCertificate(
      authority,
      {.alternative_names = "DNS:localhost,IP:127.0.0.1", .ends_s = ends_s});
}

std::string TlsTest::PutFile(const std::string& name,
                             const std::string& bytes) const {
  std::string path = folder_ + "/" + name;
  EXPECT_TRUE(base::WriteFileAtomically(path, bytes).ok());
  return path;
}

void TlsTest::Rotate(const access::MadeCertificate& next) {
  PutFile("tls.crt", next.certificate);
  NextPoll();
  PutFile("tls.key", next.key);
  NextPoll();
}

void TlsTest::Open(bool ask_clients, bool require) {
  auto files = access::CertificateFiles::Open(
      {.certificate_file = folder_ + "/tls.crt",
       .key_file = folder_ + "/tls.key",
       .client_ca_file = ask_clients ? folder_ + "/clients.crt" : "",
       .require_client_certificate = require},
      clock_, wall_, nullptr);
  ASSERT_TRUE(files.ok()) << files.status();
  files_ = *std::move(files);
}

bool SpeaksTls(int port, int version) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(
      connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)),
      0);
  SSL_CTX* context = SSL_CTX_new(TLS_client_method());
  // Debian's defaults would keep this side from speaking the old versions.
  SSL_CTX_set_cipher_list(context, "ALL:@SECLEVEL=0");
  SSL_CTX_set_min_proto_version(context, TLS1_VERSION);
  SSL_CTX_set_max_proto_version(context, version);
  static const unsigned char kHttp2[] = "\x02h2";
  SSL_CTX_set_alpn_protos(context, kHttp2, 3);
  SSL* connection = SSL_new(context);
  SSL_set_fd(connection, fd);
  const bool made = SSL_connect(connection) == 1;
  SSL_free(connection);
  SSL_CTX_free(context);
  ERR_clear_error();
  close(fd);
  return made;
}

}  // namespace treeline

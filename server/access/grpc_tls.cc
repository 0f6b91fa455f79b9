#include "server/access/grpc_tls.h"

#include <grpc/grpc_security.h>
#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/server_credentials.h>

#include "server/access/openssl.h"

namespace treeline::access {
namespace {

// Called by gRPC before each handshake, by one thread of a listener at a time.
grpc_ssl_certificate_config_reload_status FetchCertificate(
    void* reader, grpc_ssl_server_certificate_config** config) {
  const std::shared_ptr<const TlsMaterial> next =
      static_cast<CertificateFiles::Reader*>(reader)->Next();
  if (next == nullptr) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
  const grpc_ssl_pem_key_cert_pair pair = {next->key.c_str(),
                                           next->certificate.c_str()};
  // gRPC wants authorities even where no client is asked, and so they vouch for
  // nobody: it aborts without (GPR_DEBUG_ASSERT, which Debian's build keeps).
  const std::string& authorities =
      next->client_ca.empty() ? next->certificate : next->client_ca;
  *config =
      grpc_ssl_server_certificate_config_create(authorities.c_str(), &pair, 1);
  return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
}

grpc_ssl_client_certificate_request_type RequestType(
    const TlsOptions& options) {
  if (options.client_ca_file.empty()) {
    return GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE;
  }
  return options.require_client_certificate
             ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
             : GRPC_SSL_REQUEST_CLIENT_CERTIFICATE_AND_VERIFY;
}

// gRPC's C++ interface has no credentials that ask for their certificate; its C
// interface has.
class ReloadingCredentials final : public grpc::ServerCredentials {
 public:
  explicit ReloadingCredentials(CertificateFiles& files) : files_(files) {}

  void SetAuthMetadataProcessor(
      const std::shared_ptr<grpc::AuthMetadataProcessor>& /*processor*/)
      override {}

 private:
  int AddPortToServer(const std::string& address,
                      grpc_server* server) override {
    // Each listener has its own reader, which says whether there is news to it.
    grpc_server_credentials* credentials =
        grpc_ssl_server_credentials_create_with_options(
            grpc_ssl_server_credentials_create_options_using_config_fetcher(
                RequestType(files_.options()), FetchCertificate,
                &files_.NewReader()));
    const int port =
        grpc_server_add_http2_port(server, address.c_str(), credentials);
    grpc_server_credentials_release(credentials);
    return port;
  }

  CertificateFiles& files_;
};

}  // namespace

std::shared_ptr<grpc::ServerCredentials> MakeServerCredentials(
    CertificateFiles& files) {
  return std::make_shared<ReloadingCredentials>(files);
}

std::vector<std::string> CertificateNames(const grpc::AuthContext& context) {
  const std::vector<grpc::string_ref> pem =
      context.FindPropertyValues(GRPC_X509_PEM_CERT_PROPERTY_NAME);
  if (pem.empty()) return {};
  const std::vector<X509Ptr> certificates = ReadCertificates(
      absl::string_view(pem.front().data(), pem.front().size()));
  if (certificates.empty()) return {};
  return NamesIn(*certificates.front());
}

}  // namespace treeline::access

#include "server/access/http_tls.h"

#include <utility>

#include "server/access/openssl.h"

namespace treeline::access {

// Immutable; shared by the connections that are being made.
struct HttpTls::Parsed {
  std::shared_ptr<const TlsMaterial> source;
  std::vector<X509Ptr> chain;
  PkeyPtr key;
  std::vector<X509Ptr> client_ca;
  // Null: no client is asked for a certificate.
  X509StorePtr trusted;
};

HttpTls::HttpTls(CertificateFiles& files) : files_(files) {}

HttpTls::~HttpTls() = default;

bool HttpTls::Configure(ssl_ctx_st& context) {
  if (SSL_CTX_set_min_proto_version(&context, TLS1_2_VERSION) != 1) {
    return false;
  }
  // No connection is resumed: each has its certificates verified.
  SSL_CTX_set_options(&context, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION |
                                    SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_session_cache_mode(&context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_cert_cb(&context, &HttpTls::UseCertificate, this);
  const TlsOptions& options = files_.options();
  if (!options.client_ca_file.empty()) {
    const int required = options.require_client_certificate
                             ? SSL_VERIFY_FAIL_IF_NO_PEER_CERT
                             : 0;
    SSL_CTX_set_verify(&context, SSL_VERIFY_PEER | required, nullptr);
  }
  return true;
}

std::shared_ptr<const HttpTls::Parsed> HttpTls::Current() {
  const std::shared_ptr<const TlsMaterial> material = files_.Current();
  {
    const absl::MutexLock lock(&mutex_);
    if (parsed_ != nullptr && parsed_->source == material) return parsed_;
  }
  auto parsed = std::make_shared<Parsed>();
  parsed->source = material;
  parsed->chain = ReadCertificates(material->certificate);
  parsed->key = ReadPrivateKey(material->key);
  if (!material->client_ca.empty()) {
    parsed->client_ca = ReadCertificates(material->client_ca);
    parsed->trusted.reset(X509_STORE_new());
    for (const X509Ptr& certificate : parsed->client_ca) {
      X509_STORE_add_cert(parsed->trusted.get(), certificate.get());
    }
  }
  const absl::MutexLock lock(&mutex_);
  parsed_ = parsed;
  return parsed;
}

int HttpTls::UseCertificate(ssl_st* connection, void* self) {
  const std::shared_ptr<const Parsed> parsed =
      static_cast<HttpTls*>(self)->Current();
  if (parsed->chain.empty() ||
      SSL_use_certificate(connection, parsed->chain.front().get()) != 1 ||
      SSL_use_PrivateKey(connection, parsed->key.get()) != 1) {
    return 0;
  }
  for (size_t i = 1; i < parsed->chain.size(); ++i) {
    SSL_add1_chain_cert(connection, parsed->chain[i].get());
  }
  if (parsed->trusted != nullptr) {
    SSL_set1_verify_cert_store(connection, parsed->trusted.get());
    for (const X509Ptr& certificate : parsed->client_ca) {
      SSL_add_client_CA(connection, certificate.get());
    }
  }
  return 1;
}

std::vector<std::string> CertificateNames(const ssl_st& connection) {
  const X509* certificate = SSL_get0_peer_certificate(&connection);
  if (certificate == nullptr ||
      SSL_get_verify_result(&connection) != X509_V_OK) {
    return {};
  }
  return NamesIn(*certificate);
}

}  // namespace treeline::access

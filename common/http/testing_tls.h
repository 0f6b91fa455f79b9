// TLS for tests: a certificate, and a client that trusts anyone.
#ifndef COMMON_HTTP_TESTING_TLS_H_
#define COMMON_HTTP_TESTING_TLS_H_

#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <string>

#include "absl/strings/string_view.h"
#include "common/http/testing_raw_client.h"

namespace treeline::http {

// A key and a certificate that it has signed itself.
class SelfSigned {
 public:
  SelfSigned() : key_(EVP_EC_gen("P-256")), certificate_(X509_new()) {
    X509_set_version(certificate_, X509_VERSION_3);
    X509_gmtime_adj(X509_getm_notBefore(certificate_), -60);
    X509_gmtime_adj(X509_getm_notAfter(certificate_), 3600);
    X509_NAME* name = X509_get_subject_name(certificate_);
    X509_NAME_add_entry_by_txt(
        name, "CN", MBSTRING_ASC,
        reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
    X509_set_issuer_name(certificate_, name);
    X509_set_pubkey(certificate_, key_);
    X509_sign(certificate_, key_, EVP_sha256());
  }
  ~SelfSigned() {
    X509_free(certificate_);
    EVP_PKEY_free(key_);
  }
  SelfSigned(const SelfSigned&) = delete;
  SelfSigned& operator=(const SelfSigned&) = delete;

  bool Configure(SSL_CTX& context) const {
    return SSL_CTX_use_certificate(&context, certificate_) == 1 &&
           SSL_CTX_use_PrivateKey(&context, key_) == 1;
  }

 private:
  EVP_PKEY* key_;
  X509* certificate_;
};

// A connection with TLS.
class TlsClient final : public RawClient {
 public:
  explicit TlsClient(const std::string& address)
      : RawClient(address),
        context_(SSL_CTX_new(TLS_client_method())),
        ssl_(SSL_new(context_)) {
    SSL_set_fd(ssl_, fd());
    EXPECT_EQ(SSL_connect(ssl_), 1);
  }
  ~TlsClient() override {
    SSL_free(ssl_);
    SSL_CTX_free(context_);
  }

  bool Send(absl::string_view bytes) const override {
    return SSL_write(ssl_, bytes.data(), static_cast<int>(bytes.size())) ==
           static_cast<int>(bytes.size());
  }

 private:
  ssize_t Receive(char* to, size_t size) const override {
    return SSL_read(ssl_, to, static_cast<int>(size));
  }

  SSL_CTX* context_;
  SSL* ssl_;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_TESTING_TLS_H_

// TLS of the HTTP listener.
#ifndef SERVER_ACCESS_HTTP_TLS_H_
#define SERVER_ACCESS_HTTP_TLS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/access/tls.h"

// OpenSSL's SSL_CTX and SSL.
struct ssl_ctx_st;
struct ssl_st;

namespace treeline::access {

// Sets up an SSL_CTX so that every connection is made with what the files held
// at most one poll interval before:
//
//   HttpTls tls(files);
//   httplib::SSLServer server(
//       [&tls](SSL_CTX& context) { return tls.Configure(context); });
//
// Thread-safe.
class HttpTls {
 public:
  // `files` must outlive this.
  explicit HttpTls(CertificateFiles& files);
  ~HttpTls();

  // TLS 1.2 or newer; clients' certificates as the options say. False if
  // OpenSSL refuses. This must outlive the context.
  bool Configure(ssl_ctx_st& context);

 private:
  struct Parsed;

  // OpenSSL's callback before each handshake.
  static int UseCertificate(ssl_st* connection, void* self);
  std::shared_ptr<const Parsed> Current();

  CertificateFiles& files_;
  absl::Mutex mutex_;
  std::shared_ptr<const Parsed> parsed_ ABSL_GUARDED_BY(mutex_);
};

// The names in the certificate that the client has shown, for
// Credentials::certificate_names; empty without one. httplib::Request::ssl has
// the connection.
std::vector<std::string> CertificateNames(const ssl_st& connection);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_HTTP_TLS_H_

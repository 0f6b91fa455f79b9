// TLS of the gRPC listeners.
#ifndef SERVER_ACCESS_GRPC_TLS_H_
#define SERVER_ACCESS_GRPC_TLS_H_

#include <memory>
#include <string>
#include <vector>

#include "server/access/tls.h"

namespace grpc {
class AuthContext;
class ServerCredentials;
}  // namespace grpc

namespace treeline::access {

// TLS 1.2 or newer with the files' certificate; every connection is made with
// what the files held at most one poll interval before, and established ones
// stay. `files` must outlive the server. gRPC's own watcher of files is not
// used: see docs/adr/0017-certificates-read-by-us.md.
std::shared_ptr<grpc::ServerCredentials> MakeServerCredentials(
    CertificateFiles& files);

// The names in the certificate that the client has shown (see NamesIn of
// server/access/openssl.h), for Credentials::certificate_names; empty without
// one. TLS has verified it.
std::vector<std::string> CertificateNames(const grpc::AuthContext& context);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_GRPC_TLS_H_

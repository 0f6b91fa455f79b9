// Certificates, as an authority would make them. For tests.
#ifndef SERVER_ACCESS_CERTIFICATE_MAKER_H_
#define SERVER_ACCESS_CERTIFICATE_MAKER_H_

#include <cstdint>
#include <string>
#include <vector>

namespace treeline::access {

struct MadeCertificate {
  // Both as PEM.
  std::string certificate;
  std::string key;
};

struct CertificateSpec {
  std::string common_name = "localhost";
  // For instance "DNS:localhost,IP:127.0.0.1,URI:spiffe://example/robot".
  std::string alternative_names = {};
  // From now.
  int64_t begins_s = -3600;
  int64_t ends_s = 90 * 86400;
};

// An authority that signs itself. Dies on failure, as the next one does.
MadeCertificate MakeAuthority(const std::string& common_name);

// Of a server or a client, with a key (P-256) of its own.
MadeCertificate MakeCertificate(const MadeCertificate& authority,
                                const CertificateSpec& spec);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_CERTIFICATE_MAKER_H_

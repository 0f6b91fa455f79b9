// Certificates in files, for servers on real sockets.
#ifndef TESTS_INTEGRATION_TLS_FIXTURE_H_
#define TESTS_INTEGRATION_TLS_FIXTURE_H_

#include <memory>
#include <string>

#include "gtest/gtest.h"
#include "server/access/certificate_maker.h"
#include "server/access/fake_clocks.h"
#include "server/access/tls.h"

namespace treeline {

class TlsTest : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  // A certificate for localhost and 127.0.0.1.
  static access::MadeCertificate ServerCertificate(
      const access::MadeCertificate& authority, int64_t ends_s = 90 * 86400);

  std::string PutFile(const std::string& name, const std::string& bytes) const;
  // Puts the server's certificate in two steps, and lets the server look after
  // each.
  void Rotate(const access::MadeCertificate& next);
  void Open(bool ask_clients, bool require = false);
  void NextPoll() { clock_.Advance(std::chrono::seconds(1)); }

  std::string folder_;
  access::FakeClock clock_;
  access::SystemWallClock wall_;
  const access::MadeCertificate authority_ = access::MakeAuthority("Test CA");
  const access::MadeCertificate stranger_ = access::MakeAuthority("Another CA");
  std::unique_ptr<access::CertificateFiles> files_;
};

// Whether a server on 127.0.0.1:`port` makes a connection with this version of
// TLS at most (TLS1_1_VERSION...).
bool SpeaksTls(int port, int version);

}  // namespace treeline

#endif  // TESTS_INTEGRATION_TLS_FIXTURE_H_

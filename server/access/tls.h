// The certificate of the server, and whose certificates it accepts, as files
// that may be replaced while it serves.
#ifndef SERVER_ACCESS_TLS_H_
#define SERVER_ACCESS_TLS_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/access/poll_gate.h"
#include "server/access/trust_log.h"
#include "server/access/wall_clock.h"

namespace treeline::access {

struct TlsOptions {
  // The certificate chain as PEM, the server's own certificate first.
  std::string certificate_file = {};
  // Its private key as PEM, without a passphrase.
  std::string key_file = {};
  // Certificates (PEM) of those who may sign clients' certificates; empty: no
  // client is asked for one.
  std::string client_ca_file = {};
  // Whether clients without a certificate are turned away; else they may still
  // show a token. Needs client_ca_file.
  bool require_client_certificate = false;
  // How often the files are looked at, 10 ms or more.
  std::chrono::milliseconds poll_interval = std::chrono::seconds(1);

  // Reads the files: INVALID_ARGUMENT, NOT_FOUND, PERMISSION_DENIED... name the
  // file that cannot be read or parsed, and a key that is not the
  // certificate's.
  absl::Status Validate() const;
};

// What the files held when they were consistent. PEM, as it was read.
struct TlsMaterial {
  std::string certificate = {};
  std::string key = {};
  std::string client_ca = {};
  // When the server's own certificate ends.
  int64_t expires_unix_s = 0;
};

// Thread-safe.
class CertificateFiles {
 public:
  // Errors as of TlsOptions::Validate. A certificate that has expired, or will
  // within 14 days, is taken and logged; so are a key that everyone may read,
  // and later every new certificate. The clocks must outlive the files.
  static absl::StatusOr<std::unique_ptr<CertificateFiles>> Open(
      const TlsOptions& options, const base::Clock& clock,
      const WallClock& wall, TrustLog log);

  // At most once in an interval, the caller's thread looks whether the files
  // have other contents. Contents that are not consistent (a key that is not
  // the certificate's: one of the two files has not been replaced yet), and a
  // certificate that has expired in the place of one that has not, leave what
  // is there and are logged once.
  std::shared_ptr<const TlsMaterial> Current();

  // One consumer that needs to know whether the material is new to it. Lives as
  // long as the files.
  class Reader {
   public:
    explicit Reader(CertificateFiles& files) : files_(files) {}
    // nullptr: what it returned last is current. Thread-safe.
    std::shared_ptr<const TlsMaterial> Next();

   private:
    CertificateFiles& files_;
    absl::Mutex mutex_;
    std::shared_ptr<const TlsMaterial> last_ ABSL_GUARDED_BY(mutex_);
  };
  Reader& NewReader();

  const TlsOptions& options() const { return options_; }

 private:
  CertificateFiles(const TlsOptions& options, const base::Clock& clock,
                   const WallClock& wall, TrustLog log);

  absl::Status CheckReplacement(const TlsMaterial& next) const;
  void Poll();
  void WarnOfExpiry();
  void Log(TrustSeverity severity, const std::string& message) const;

  const TlsOptions options_;
  const base::Clock& clock_;
  const WallClock& wall_;
  const TrustLog log_;
  PollGate gate_;
  // Touched only by the thread that the gate let in.
  std::string last_error_;
  int64_t warned_days_ = INT64_MAX;
  // Changed by that thread alone.
  mutable absl::Mutex mutex_;
  std::shared_ptr<const TlsMaterial> material_ ABSL_GUARDED_BY(mutex_);
  std::deque<Reader> readers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_TLS_H_

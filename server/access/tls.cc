#include "server/access/tls.h"

#include <ctime>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/access/openssl.h"
#include "server/access/secret_file.h"

namespace treeline::access {
namespace {

constexpr uint64_t kMaxBytes = 1 << 20;
constexpr int64_t kSecondsPerDay = 86400;
// Below each of these an operator hears of it once more.
constexpr int64_t kWarningDays[] = {0, 1, 3, 7, 14};

absl::Status Bad(const std::string& path, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", what));
}

int64_t ToUnixSeconds(const ASN1_TIME* time) {
  std::tm fields = {};
  if (ASN1_TIME_to_tm(time, &fields) != 1) return 0;
  return timegm(&fields);
}

absl::StatusOr<TlsMaterial> ReadMaterial(const TlsOptions& options) {
  TlsMaterial material;
  TL_ASSIGN_OR_RETURN(material.certificate,
                      base::ReadFile(options.certificate_file, kMaxBytes));
  TL_ASSIGN_OR_RETURN(material.key,
                      base::ReadFile(options.key_file, kMaxBytes));
  const std::vector<X509Ptr> chain = ReadCertificates(material.certificate);
  if (chain.empty()) {
    return Bad(options.certificate_file, "no certificate in PEM");
  }
  const PkeyPtr key = ReadPrivateKey(material.key);
  if (key == nullptr) {
    return Bad(options.key_file,
               "no private key in PEM, or one with a passphrase");
  }
  if (X509_check_private_key(chain.front().get(), key.get()) != 1) {
    TakeOpenSslError();
    return Bad(options.key_file,
               absl::StrCat("not the key of ", options.certificate_file));
  }
  material.expires_unix_s =
      ToUnixSeconds(X509_get0_notAfter(chain.front().get()));
  if (!options.client_ca_file.empty()) {
    TL_ASSIGN_OR_RETURN(material.client_ca,
                        base::ReadFile(options.client_ca_file, kMaxBytes));
    if (ReadCertificates(material.client_ca).empty()) {
      return Bad(options.client_ca_file, "no certificate in PEM");
    }
  }
  return material;
}

bool SameFiles(const TlsMaterial& a, const TlsMaterial& b) {
  return a.certificate == b.certificate && a.key == b.key &&
         a.client_ca == b.client_ca;
}

}  // namespace

absl::Status TlsOptions::Validate() const {
  if (certificate_file.empty() || key_file.empty()) {
    return absl::InvalidArgumentError(
        "TLS needs both a certificate and its key");
  }
  if (require_client_certificate && client_ca_file.empty()) {
    return absl::InvalidArgumentError(
        "clients' certificates are required, but nobody is named who may sign "
        "them");
  }
  if (poll_interval < std::chrono::milliseconds(10)) {
    return absl::InvalidArgumentError(
        "certificates cannot be looked at more often than every 10 ms");
  }
  return ReadMaterial(*this).status();
}

CertificateFiles::CertificateFiles(const TlsOptions& options,
                                   const base::Clock& clock,
                                   const WallClock& wall, TrustLog log)
    : options_(options),
      clock_(clock),
      wall_(wall),
      log_(std::move(log)),
      gate_(clock.Now(), options.poll_interval) {}

absl::StatusOr<std::unique_ptr<CertificateFiles>> CertificateFiles::Open(
    const TlsOptions& options, const base::Clock& clock, const WallClock& wall,
    TrustLog log) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(TlsMaterial material, ReadMaterial(options));
  std::unique_ptr<CertificateFiles> files(
      new CertificateFiles(options, clock, wall, std::move(log)));
  WarnIfOthersMayRead(options.key_file, files->log_);
  {
    const absl::MutexLock lock(&files->mutex_);
    files->material_ = std::make_shared<const TlsMaterial>(std::move(material));
  }
  files->WarnOfExpiry();
  return files;
}

std::shared_ptr<const TlsMaterial> CertificateFiles::Current() {
  if (gate_.Enter(clock_.Now())) {
    Poll();
    gate_.Done();
  }
  const absl::MutexLock lock(&mutex_);
  return material_;
}

absl::Status CertificateFiles::CheckReplacement(const TlsMaterial& next) const {
  const int64_t now = wall_.UnixSeconds();
  const absl::MutexLock lock(&mutex_);
  if (next.expires_unix_s <= now && material_->expires_unix_s > now) {
    return Bad(options_.certificate_file, "it has expired");
  }
  return absl::OkStatus();
}

void CertificateFiles::Poll() {
  absl::StatusOr<TlsMaterial> next = ReadMaterial(options_);
  absl::Status status = next.status();
  if (status.ok()) status = CheckReplacement(*next);
  if (!status.ok()) {
    const std::string error(status.message());
    if (error != last_error_) {
      Log(TrustSeverity::kWarning,
          absl::StrCat("the new certificate is not used, the old one stays: ",
                       error));
    }
    last_error_ = error;
    WarnOfExpiry();
    return;
  }
  last_error_.clear();
  bool replaced = false;
  {
    const absl::MutexLock lock(&mutex_);
    if (!SameFiles(*material_, *next)) {
      material_ = std::make_shared<const TlsMaterial>(*std::move(next));
      replaced = true;
    }
  }
  if (replaced) {
    warned_days_ = INT64_MAX;
    Log(TrustSeverity::kInfo, absl::StrCat("certificate read again from ",
                                           options_.certificate_file));
    WarnIfOthersMayRead(options_.key_file, log_);
  }
  WarnOfExpiry();
}

void CertificateFiles::WarnOfExpiry() {
  int64_t left_s = 0;
  {
    const absl::MutexLock lock(&mutex_);
    left_s = material_->expires_unix_s - wall_.UnixSeconds();
  }
  for (const int64_t days : kWarningDays) {
    if (left_s > days * kSecondsPerDay) continue;
    if (days < warned_days_) {
      warned_days_ = days;
      Log(TrustSeverity::kWarning,
          left_s <= 0 ? absl::StrCat(options_.certificate_file, " has expired")
                      : absl::StrCat(options_.certificate_file, " expires in ",
                                     left_s / kSecondsPerDay, " days"));
    }
    return;
  }
}

void CertificateFiles::Log(TrustSeverity severity,
                           const std::string& message) const {
  if (log_ != nullptr) log_(severity, message);
}

std::shared_ptr<const TlsMaterial> CertificateFiles::Reader::Next() {
  std::shared_ptr<const TlsMaterial> current = files_.Current();
  const absl::MutexLock lock(&mutex_);
  if (current == last_) return nullptr;
  last_ = current;
  return current;
}

CertificateFiles::Reader& CertificateFiles::NewReader() {
  const absl::MutexLock lock(&mutex_);
  return readers_.emplace_back(*this);
}

}  // namespace treeline::access

#include "server/access/certificate_maker.h"

#include <openssl/ec.h>
#include <openssl/pem.h>

#include <atomic>
#include <cstdlib>
#include <ctime>

#include "server/access/openssl.h"

namespace treeline::access {
namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

void AddExtension(X509* certificate, X509* issuer, int id,
                  const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension =
      X509V3_EXT_conf_nid(nullptr, &context, id, value.c_str());
  Require(extension != nullptr);
  Require(X509_add_ext(certificate, extension, -1) == 1);
  X509_EXTENSION_free(extension);
}

X509Ptr MakeUnsigned(const CertificateSpec& spec, EVP_PKEY* key) {
  static std::atomic<long> serial = 1000;
  X509Ptr certificate(X509_new());
  X509_set_version(certificate.get(), X509_VERSION_3);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), ++serial);
  const std::time_t now = std::time(nullptr);
  ASN1_TIME_set(X509_getm_notBefore(certificate.get()), now + spec.begins_s);
  ASN1_TIME_set(X509_getm_notAfter(certificate.get()), now + spec.ends_s);
  X509_NAME* subject = X509_get_subject_name(certificate.get());
  Require(X509_NAME_add_entry_by_txt(
              subject, "CN", MBSTRING_UTF8,
              reinterpret_cast<const unsigned char*>(spec.common_name.data()),
              static_cast<int>(spec.common_name.size()), -1, 0) == 1);
  Require(X509_set_pubkey(certificate.get(), key) == 1);
  return certificate;
}

MadeCertificate ToPem(X509* certificate, EVP_PKEY* key) {
  const BioPtr certificate_bio(BIO_new(BIO_s_mem()));
  const BioPtr key_bio(BIO_new(BIO_s_mem()));
  Require(PEM_write_bio_X509(certificate_bio.get(), certificate) == 1);
  Require(PEM_write_bio_PrivateKey(key_bio.get(), key, nullptr, nullptr, 0,
                                   nullptr, nullptr) == 1);
  return {Written(*certificate_bio), Written(*key_bio)};
}

}  // namespace

MadeCertificate MakeAuthority(const std::string& common_name) {
  const PkeyPtr key(EVP_EC_gen("P-256"));
  const X509Ptr certificate =
      MakeUnsigned({.common_name = common_name}, key.get());
  X509_set_issuer_name(certificate.get(),
                       X509_get_subject_name(certificate.get()));
  AddExtension(certificate.get(), certificate.get(), NID_basic_constraints,
               "critical,CA:TRUE");
  AddExtension(certificate.get(), certificate.get(), NID_key_usage,
               "critical,keyCertSign,cRLSign");
  Require(X509_sign(certificate.get(), key.get(), EVP_sha256()) > 0);
  return ToPem(certificate.get(), key.get());
}

MadeCertificate MakeCertificate(const MadeCertificate& authority,
                                const CertificateSpec& spec) {
  const std::vector<X509Ptr> issuer = ReadCertificates(authority.certificate);
  const PkeyPtr issuer_key = ReadPrivateKey(authority.key);
  Require(!issuer.empty() && issuer_key != nullptr);
  const PkeyPtr key(EVP_EC_gen("P-256"));
  const X509Ptr certificate = MakeUnsigned(spec, key.get());
  X509_set_issuer_name(certificate.get(),
                       X509_get_subject_name(issuer.front().get()));
  if (!spec.alternative_names.empty()) {
    AddExtension(certificate.get(), issuer.front().get(), NID_subject_alt_name,
                 spec.alternative_names);
  }
  Require(X509_sign(certificate.get(), issuer_key.get(), EVP_sha256()) > 0);
  return ToPem(certificate.get(), key.get());
}

}  // namespace treeline::access

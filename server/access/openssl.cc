#include "server/access/openssl.h"

#include <openssl/err.h>
#include <openssl/pem.h>

namespace treeline::access {
namespace {

// In the place of OpenSSL's own, which asks on the terminal.
int NoPassphrase(char* /*buffer*/, int /*size*/, int /*writing*/,
                 void* /*context*/) {
  return -1;
}

void Append(const ASN1_STRING* text, std::vector<std::string>* names) {
  unsigned char* utf8 = nullptr;
  const int size = ASN1_STRING_to_UTF8(&utf8, text);
  if (size > 0) {
    std::string name(reinterpret_cast<const char*>(utf8),
                     static_cast<size_t>(size));
    if (name.find('\0') == std::string::npos) {
      names->push_back(std::move(name));
    }
  }
  OPENSSL_free(utf8);
}

}  // namespace

BioPtr ReadingBio(absl::string_view text) {
  return BioPtr(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

std::string Written(BIO& bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(&bio, &data);
  return size > 0 ? std::string(data, static_cast<size_t>(size)) : "";
}

std::string TakeOpenSslError() {
  const unsigned long code = ERR_peek_last_error();
  ERR_clear_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return reason == nullptr ? "no reason given" : reason;
}

std::vector<X509Ptr> ReadCertificates(absl::string_view pem) {
  std::vector<X509Ptr> certificates;
  const BioPtr bio = ReadingBio(pem);
  while (true) {
    X509Ptr certificate(
        PEM_read_bio_X509(bio.get(), nullptr, NoPassphrase, nullptr));
    if (certificate == nullptr) break;
    certificates.push_back(std::move(certificate));
  }
  const bool at_end =
      ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  ERR_clear_error();
  if (!at_end) certificates.clear();
  return certificates;
}

PkeyPtr ReadPrivateKey(absl::string_view pem) {
  const BioPtr bio = ReadingBio(pem);
  PkeyPtr key(
      PEM_read_bio_PrivateKey(bio.get(), nullptr, NoPassphrase, nullptr));
  ERR_clear_error();
  return key;
}

std::vector<std::string> NamesIn(const X509& certificate) {
  std::vector<std::string> names;
  const GeneralNamesPtr alternatives(static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(&certificate, NID_subject_alt_name, nullptr, nullptr)));
  const int count =
      alternatives == nullptr ? 0 : sk_GENERAL_NAME_num(alternatives.get());
  for (int i = 0; i < count; ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(alternatives.get(), i);
    if (name->type == GEN_DNS) Append(name->d.dNSName, &names);
    if (name->type == GEN_URI) {
      Append(name->d.uniformResourceIdentifier, &names);
    }
  }
  if (names.empty()) {
    const X509_NAME* subject = X509_get_subject_name(&certificate);
    const int at = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
    if (at >= 0) {
      Append(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at)),
             &names);
    }
  }
  ERR_clear_error();
  return names;
}

}  // namespace treeline::access

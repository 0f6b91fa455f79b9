// OpenSSL's objects with owners. For the .cc files of this folder.
#ifndef SERVER_ACCESS_OPENSSL_H_
#define SERVER_ACCESS_OPENSSL_H_

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/evp.h>
#include <openssl/param_build.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::access {

template <auto kFree>
struct OpenSslFree {
  template <typename T>
  void operator()(T* object) const {
    kFree(object);
  }
};

using BioPtr = std::unique_ptr<BIO, OpenSslFree<BIO_free_all>>;
using BignumPtr = std::unique_ptr<BIGNUM, OpenSslFree<BN_free>>;
using PkeyPtr = std::unique_ptr<EVP_PKEY, OpenSslFree<EVP_PKEY_free>>;
using PkeyContextPtr =
    std::unique_ptr<EVP_PKEY_CTX, OpenSslFree<EVP_PKEY_CTX_free>>;
using DigestContextPtr =
    std::unique_ptr<EVP_MD_CTX, OpenSslFree<EVP_MD_CTX_free>>;
using ParamsPtr = std::unique_ptr<OSSL_PARAM, OpenSslFree<OSSL_PARAM_free>>;
using ParamsBuilderPtr =
    std::unique_ptr<OSSL_PARAM_BLD, OpenSslFree<OSSL_PARAM_BLD_free>>;
using X509Ptr = std::unique_ptr<X509, OpenSslFree<X509_free>>;
using X509StorePtr = std::unique_ptr<X509_STORE, OpenSslFree<X509_STORE_free>>;
using GeneralNamesPtr =
    std::unique_ptr<GENERAL_NAMES, OpenSslFree<GENERAL_NAMES_free>>;

// A BIO that reads `text`, which must outlive it.
BioPtr ReadingBio(absl::string_view text);

// What was written to a memory BIO.
std::string Written(BIO& bio);

// Why the last call failed; the thread's queue of errors is empty afterwards.
std::string TakeOpenSslError();

// All certificates in `pem`, in their order; empty if there is none or if one
// is malformed. Never asks for a passphrase.
std::vector<X509Ptr> ReadCertificates(absl::string_view pem);

// nullptr if there is none, if it is malformed, or if it is encrypted.
PkeyPtr ReadPrivateKey(absl::string_view pem);

// The subject alternative names (DNS names and URIs) of a certificate, or else
// its common name. A name with a NUL inside is left out.
std::vector<std::string> NamesIn(const X509& certificate);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_OPENSSL_H_

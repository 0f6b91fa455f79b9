// Keys for tests of signed indices.
#ifndef SERVER_REPOSITORY_TESTING_INDEX_KEYS_H_
#define SERVER_REPOSITORY_TESTING_INDEX_KEYS_H_

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>

#include <memory>
#include <string>

namespace treeline::repository {

// A key pair as PEM.
struct TestKeyPair {
  std::string secret;
  std::string open;
};

// `type` as OpenSSL calls it; of another than Ed25519 an index takes none.
inline TestKeyPair MakeTestKeyPair(const char* type = "ED25519") {
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      EVP_PKEY_Q_keygen(nullptr, nullptr, type), &EVP_PKEY_free);
  const auto written = [](auto write) {
    const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new(BIO_s_mem()),
                                                        &BIO_free);
    write(bio.get());
    const char* data = nullptr;
    const auto size = BIO_get_mem_data(bio.get(), &data);
    return std::string(data, static_cast<size_t>(size));
  };
  return {
      .secret = written([&](BIO* bio) {
        PEM_write_bio_PrivateKey(bio, key.get(), nullptr, nullptr, 0, nullptr,
                                 nullptr);
      }),
      .open = written([&](BIO* bio) { PEM_write_bio_PUBKEY(bio, key.get()); })};
}

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_TESTING_INDEX_KEYS_H_

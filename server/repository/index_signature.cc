#include "server/repository/index_signature.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/repository/sha256.h"

namespace treeline::repository {

struct IndexKey {
  struct Deleter {
    void operator()(EVP_PKEY* owned) const { EVP_PKEY_free(owned); }
  };
  std::unique_ptr<EVP_PKEY, Deleter> key;
};

namespace {

constexpr size_t kMaxKeys = 64;
// What makes the text one of ours, and of this form.
constexpr absl::string_view kHead = "treeline index of models 1\n";

struct BioDeleter {
  void operator()(BIO* bio) const { BIO_free(bio); }
};
using BioPtr = std::unique_ptr<BIO, BioDeleter>;

struct ContextDeleter {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};
using ContextPtr = std::unique_ptr<EVP_MD_CTX, ContextDeleter>;

BioPtr BioOf(absl::string_view pem) {
  return BioPtr(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

const unsigned char* BytesOf(absl::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

// Asks nobody for a passphrase.
int NoPassphrase(char* /*buffer*/, int /*size*/, int /*writing*/,
                 void* /*data*/) {
  return 0;
}

bool IsEd25519(const EVP_PKEY& key) {
  return EVP_PKEY_is_a(&key, "ED25519") == 1;
}

struct PemBlock {
  std::string kind;
  std::string der;
};

// The next one; nullopt: there is none any more. INVALID_ARGUMENT: it is cut
// off.
absl::StatusOr<std::optional<PemBlock>> NextBlock(BIO& bio) {
  char* kind = nullptr;
  char* header = nullptr;
  unsigned char* data = nullptr;
  long size = 0;
  if (PEM_read_bio(&bio, &kind, &header, &data, &size) == 1) {
    PemBlock block{.kind = kind,
                   .der = std::string(reinterpret_cast<const char*>(data),
                                      static_cast<size_t>(size))};
    OPENSSL_free(kind);
    OPENSSL_free(header);
    OPENSSL_free(data);
    return block;
  }
  const bool at_end =
      ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  ERR_clear_error();
  if (at_end) return std::nullopt;
  return absl::InvalidArgumentError("PEM that is damaged or cut off");
}

absl::StatusOr<std::shared_ptr<const IndexKey>> PublicKeyOf(
    const PemBlock& block) {
  const unsigned char* der = BytesOf(block.der);
  auto key = std::make_shared<IndexKey>();
  if (block.kind == PEM_STRING_PUBLIC) {
    key->key.reset(
        d2i_PUBKEY(nullptr, &der, static_cast<long>(block.der.size())));
    ERR_clear_error();
  }
  if (key->key == nullptr || !IsEd25519(*key->key)) {
    return absl::InvalidArgumentError(
        absl::StrCat(block.kind,
                     " that is no public Ed25519 key, as `openssl pkey "
                     "-pubout` writes it"));
  }
  return key;
}

absl::Status NotTrusted(absl::string_view message, absl::string_view reason) {
  return base::WithReason(absl::FailedPreconditionError(message), reason);
}

}  // namespace

std::string SignedText(const ModelIndex& index) {
  std::string text =
      absl::StrCat(kHead, "published ", index.published_unix_s, "\n");
  std::vector<const IndexedModel*> models;
  models.reserve(index.models.size());
  for (const IndexedModel& model : index.models) models.push_back(&model);
  std::sort(models.begin(), models.end(),
            [](const IndexedModel* a, const IndexedModel* b) {
              return std::tie(a->scene, a->version) <
                     std::tie(b->scene, b->version);
            });
  // Names have no spaces.
  for (const IndexedModel* model : models) {
    absl::StrAppend(&text, "model ", model->scene, " ", model->version, " ",
                    model->bytes, " ", model->sha256, "\n");
  }
  for (const auto& [scene, json] : index.scene_json) {
    Sha256 hash;
    hash.Update(json);
    absl::StrAppend(&text, "scene ", scene, " ", hash.Finish(), "\n");
  }
  return text;
}

IndexSigner::IndexSigner(std::shared_ptr<const IndexKey> key)
    : key_(std::move(key)) {}

absl::StatusOr<IndexSigner> IndexSigner::FromPem(absl::string_view pem) {
  auto key = std::make_shared<IndexKey>();
  key->key.reset(PEM_read_bio_PrivateKey(BioOf(pem).get(), nullptr,
                                         &NoPassphrase, nullptr));
  ERR_clear_error();
  if (key->key == nullptr || !IsEd25519(*key->key)) {
    return absl::InvalidArgumentError(
        "not a private Ed25519 key without a passphrase, as `openssl genpkey "
        "-algorithm ed25519` writes it");
  }
  return IndexSigner(std::move(key));
}

absl::Status IndexSigner::Sign(ModelIndex& index) const {
  if (index.published_unix_s == 0) {
    return absl::InvalidArgumentError("published: is missing");
  }
  const std::string text = SignedText(index);
  const ContextPtr context(EVP_MD_CTX_new());
  std::string signature(kSignatureBytes, '\0');
  size_t size = signature.size();
  if (EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr,
                         key_->key.get()) != 1 ||
      EVP_DigestSign(context.get(),
                     reinterpret_cast<unsigned char*>(signature.data()), &size,
                     BytesOf(text), text.size()) != 1 ||
      size != kSignatureBytes) {
    ERR_clear_error();
    return absl::InternalError("OpenSSL could not sign");
  }
  index.signature = std::move(signature);
  return absl::OkStatus();
}

IndexKeys::IndexKeys(std::vector<std::shared_ptr<const IndexKey>> keys)
    : keys_(std::move(keys)) {}

absl::StatusOr<IndexKeys> IndexKeys::FromPem(absl::string_view pem) {
  std::vector<std::shared_ptr<const IndexKey>> keys;
  const BioPtr bio = BioOf(pem);
  while (true) {
    TL_ASSIGN_OR_RETURN(const std::optional<PemBlock> block, NextBlock(*bio));
    if (!block.has_value()) break;
    TL_ASSIGN_OR_RETURN(auto key, PublicKeyOf(*block));
    keys.push_back(std::move(key));
    if (keys.size() > kMaxKeys) {
      return absl::InvalidArgumentError(
          absl::StrCat("more than ", kMaxKeys, " keys"));
    }
  }
  if (keys.empty()) {
    return absl::InvalidArgumentError(
        "there is no public key in PEM, as `openssl pkey -pubout` writes it");
  }
  return IndexKeys(std::move(keys));
}

absl::Status IndexKeys::Check(const ModelIndex& index) const {
  if (index.signature.empty()) {
    return NotTrusted("the index is not signed", "INDEX_UNSIGNED");
  }
  const std::string text = SignedText(index);
  for (const auto& key : keys_) {
    const ContextPtr context(EVP_MD_CTX_new());
    const bool is_right =
        EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr,
                             key->key.get()) == 1 &&
        EVP_DigestVerify(context.get(), BytesOf(index.signature),
                         index.signature.size(), BytesOf(text),
                         text.size()) == 1;
    ERR_clear_error();
    if (is_right) return absl::OkStatus();
  }
  return NotTrusted(
      "the index is signed by none of the keys that are believed, or was "
      "changed after it was signed",
      "INDEX_SIGNATURE_WRONG");
}

}  // namespace treeline::repository

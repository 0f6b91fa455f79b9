// Who vouches for an index of models: Ed25519 (RFC 8032) over what it promises.
//
// Signed are SignedText() of the index: when it was published, every model with
// its size and digest, and every scene.json. Where the files lie is not, so
// that addresses can be presigned after it.
#ifndef SERVER_REPOSITORY_INDEX_SIGNATURE_H_
#define SERVER_REPOSITORY_INDEX_SIGNATURE_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/repository/model_index.h"

namespace treeline::repository {

// Two indices that promise the same, and no others, have the same text.
std::string SignedText(const ModelIndex& index);

// A key of OpenSSL's.
struct IndexKey;

class IndexSigner {
 public:
  // The private key, PEM without a passphrase ("openssl genpkey -algorithm
  // ed25519"). INVALID_ARGUMENT: it is none.
  static absl::StatusOr<IndexSigner> FromPem(absl::string_view pem);

  // Sets `signature`. INVALID_ARGUMENT: nothing says when it was published.
  absl::Status Sign(ModelIndex& index) const;

 private:
  explicit IndexSigner(std::shared_ptr<const IndexKey> key);
  std::shared_ptr<const IndexKey> key_;
};

// The keys that are believed. Thread-safe.
class IndexKeys {
 public:
  // Public keys, PEM, one after the other ("openssl pkey -pubout").
  // INVALID_ARGUMENT: there is none, more than 64, or one that is not Ed25519.
  static absl::StatusOr<IndexKeys> FromPem(absl::string_view pem);

  // FAILED_PRECONDITION: INDEX_UNSIGNED, or INDEX_SIGNATURE_WRONG: by none of
  // these keys, or what it promises was changed.
  absl::Status Check(const ModelIndex& index) const;

 private:
  explicit IndexKeys(std::vector<std::shared_ptr<const IndexKey>> keys);
  std::vector<std::shared_ptr<const IndexKey>> keys_;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_INDEX_SIGNATURE_H_

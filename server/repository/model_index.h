// index.json: what a web server has, as `treeline publish` writes it.
//
//   {"models": [{"scene": "kitchen", "version": "7", "bytes": 5341832,
//                "sha256": "<64 lower-case hexadecimal digits>",
//                "url": "kitchen/7/model.treeline"}],
//    "scenes": {"kitchen": {...what scene.json holds...}},
//    "published": 1764172800, "signature": "<88 characters of Base64>"}
//
// A url is absolute or relative to the index. All but `models` may be missing;
// index_signature.h has what is signed.
#ifndef SERVER_REPOSITORY_MODEL_INDEX_H_
#define SERVER_REPOSITORY_MODEL_INDEX_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::repository {

inline constexpr uint64_t kMaxIndexBytes = 16u << 20;
inline constexpr uint64_t kMaxModelBytes = uint64_t{64} << 30;
inline constexpr size_t kMaxIndexedModels = 100000;
// Of an Ed25519 signature.
inline constexpr size_t kSignatureBytes = 64;

struct IndexedModel {
  // Names, see names.h; each pair of them once.
  std::string scene;
  std::string version;
  // 1 to kMaxModelBytes.
  uint64_t bytes = 0;
  // See sha256.h.
  std::string sha256;
  // 1 to 4096 printable characters without spaces.
  std::string url;
};

struct ModelIndex {
  std::vector<IndexedModel> models;
  // Text of scene.json by scene; each is an object.
  std::map<std::string, std::string> scene_json;
  // Seconds since 1970, UTC; 0: it does not say.
  uint64_t published_unix_s = 0;
  // kSignatureBytes; empty: it is not signed.
  std::string signature = {};
};

// Strict: an unknown, missing or repeated key is an error. INVALID_ARGUMENT
// says where; it repeats no url, since that may hold a signature.
absl::StatusOr<ModelIndex> ParseModelIndex(absl::string_view text);

// What ParseModelIndex() reads. INVALID_ARGUMENT: a scene_json is not an
// object.
absl::StatusOr<std::string> ModelIndexJson(const ModelIndex& index);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_MODEL_INDEX_H_

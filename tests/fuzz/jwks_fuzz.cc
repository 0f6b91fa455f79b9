// Files of keys as arbitrary bytes: no crash, and no key that is weaker than we
// promise. What starts with a hyphen is taken for PEM.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "server/access/jwt_keys.h"

namespace treeline {
namespace {

void CheckKey(const access::JwtKey& key) {
  if (key.algorithm == access::JwtAlgorithm::kHs256) {
    if (key.material.size() < 32) std::abort();
    return;
  }
  // What was written can be read again, and is the same key.
  const auto again = access::ParsePemJwtKey(key.id, key.material);
  if (!again.ok() || again->algorithm != key.algorithm ||
      again->material != key.material) {
    std::abort();
  }
}

void Parse(absl::string_view text) {
  if (!text.empty() && text.front() == '-') {
    const auto key = access::ParsePemJwtKey("k", text);
    if (key.ok()) CheckKey(*key);
    return;
  }
  const auto keys = access::ParseJwks(
      text, {access::JwtAlgorithm::kRs256, access::JwtAlgorithm::kEs256,
             access::JwtAlgorithm::kHs256});
  if (!keys.ok()) return;
  for (const access::JwtKey& key : keys->keys()) CheckKey(key);
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}

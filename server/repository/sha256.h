// SHA-256, by which fetched models are known.
#ifndef SERVER_REPOSITORY_SHA256_H_
#define SERVER_REPOSITORY_SHA256_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::repository {

// Hashes bytes as they come.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void Update(absl::string_view bytes);
  // Of all bytes so far: 64 hexadecimal digits, lower case. Starts anew.
  std::string Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Whether `text` is what Finish() returns.
bool IsSha256(absl::string_view text);

struct FileDigest {
  uint64_t bytes = 0;
  std::string sha256;
};

// Reads the whole file. `progress` is told the bytes of each step. CANCELLED;
// errors of the file name it.
absl::StatusOr<FileDigest> DigestOfFile(
    const std::string& path, const std::stop_token& stop,
    const std::function<void(uint64_t)>& progress = {});

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SHA256_H_

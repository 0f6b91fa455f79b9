#include "server/repository/sha256.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace treeline::repository {
namespace {

constexpr size_t kDigestBytes = 32;
constexpr size_t kStepBytes = 1 << 20;

struct ContextDeleter {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

struct Sha256::State {
  std::unique_ptr<EVP_MD_CTX, ContextDeleter> context{EVP_MD_CTX_new()};

  void Start() { EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr); }
};

Sha256::Sha256() : state_(std::make_unique<State>()) { state_->Start(); }
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::Update(absl::string_view bytes) {
  EVP_DigestUpdate(state_->context.get(), bytes.data(), bytes.size());
}

std::string Sha256::Finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  EVP_DigestFinal_ex(state_->context.get(), digest.data(), nullptr);
  state_->Start();
  return absl::BytesToHexString(absl::string_view(
      reinterpret_cast<const char*>(digest.data()), kDigestBytes));
}

bool IsSha256(absl::string_view text) {
  return text.size() == 2 * kDigestBytes &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

absl::StatusOr<FileDigest> DigestOfFile(
    const std::string& path, const std::stop_token& stop,
    const std::function<void(uint64_t)>& progress) {
  const std::unique_ptr<std::FILE, FileCloser> file(
      std::fopen(path.c_str(), "rbe"));
  if (file == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat("opening ", path));
  }
  FileDigest digest;
  Sha256 hash;
  std::vector<char> step(kStepBytes);
  while (true) {
    if (stop.stop_requested()) return absl::CancelledError("cancelled");
    const size_t got = std::fread(step.data(), 1, step.size(), file.get());
    if (got == 0) break;
    hash.Update(absl::string_view(step.data(), got));
    digest.bytes += got;
    if (progress) progress(got);
  }
  if (std::ferror(file.get()) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("reading ", path));
  }
  digest.sha256 = hash.Finish();
  return digest;
}

}  // namespace treeline::repository

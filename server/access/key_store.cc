#include "server/access/key_store.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/access/secret_file.h"

namespace treeline::access {
namespace {

constexpr uint64_t kMaxBytes = 1 << 20;
constexpr size_t kMaxFiles = 64;

bool HoldsSecrets(const JwtKeySet& keys) {
  return std::any_of(
      keys.keys().begin(), keys.keys().end(),
      [](const JwtKey& key) { return key.algorithm == JwtAlgorithm::kHs256; });
}

bool IsAllowed(JwtAlgorithm algorithm,
               const std::vector<JwtAlgorithm>& allowed) {
  return std::find(allowed.begin(), allowed.end(), algorithm) != allowed.end();
}

}  // namespace

absl::Status KeyStoreOptions::Validate() const {
  if (path.empty()) return absl::InvalidArgumentError("no file of keys");
  if (algorithms.empty()) {
    return absl::InvalidArgumentError("no algorithm of tokens is allowed");
  }
  if (poll_interval < std::chrono::milliseconds(10)) {
    return absl::InvalidArgumentError(
        "keys cannot be looked at more often than every 10 ms");
  }
  return absl::OkStatus();
}

KeyStore::KeyStore(const KeyStoreOptions& options, const base::Clock& clock,
                   TrustLog log)
    : options_(options),
      clock_(clock),
      log_(std::move(log)),
      gate_(clock.Now(), options.poll_interval) {}

absl::StatusOr<std::unique_ptr<KeyStore>> KeyStore::Open(
    const KeyStoreOptions& options, const base::Clock& clock, TrustLog log) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::unique_ptr<KeyStore> store(new KeyStore(options, clock, std::move(log)));
  TL_RETURN_IF_ERROR(store->Load().status());
  return store;
}

absl::StatusOr<KeyStore::Files> KeyStore::ReadFiles() const {
  namespace fs = std::filesystem;
  Files files;
  std::error_code error;
  if (!fs::is_directory(options_.path, error)) {
    TL_ASSIGN_OR_RETURN(std::string bytes,
                        base::ReadFile(options_.path, kMaxBytes));
    files.emplace_back("", std::move(bytes));
    return files;
  }
  fs::directory_iterator entry(options_.path, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const fs::path path = entry->path();
    if (path.extension() != ".pem") continue;
    if (files.size() == kMaxFiles) {
      return absl::InvalidArgumentError(
          absl::StrCat(options_.path, ": more than ", kMaxFiles, " keys"));
    }
    TL_ASSIGN_OR_RETURN(std::string bytes,
                        base::ReadFile(path.string(), kMaxBytes));
    files.emplace_back(path.stem().string(), std::move(bytes));
  }
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("cannot read ", options_.path, ": ", error.message()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

absl::StatusOr<JwtKeySet> KeyStore::Parse(const Files& files) const {
  if (files.size() == 1 && files.front().first.empty()) {
    auto keys = ParseJwks(files.front().second, options_.algorithms);
    if (!keys.ok()) return base::Annotate(keys.status(), options_.path);
    return keys;
  }
  std::vector<JwtKey> keys;
  for (const auto& [id, pem] : files) {
    const std::string path = absl::StrCat(options_.path, "/", id, ".pem");
    auto key = ParsePemJwtKey(id, pem);
    if (!key.ok()) return base::Annotate(key.status(), path);
    if (IsAllowed(key->algorithm, options_.algorithms)) {
      keys.push_back(*std::move(key));
    }
  }
  if (keys.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        options_.path, ": no <kid>.pem of an algorithm that is allowed"));
  }
  return JwtKeySet::Make(std::move(keys));
}

absl::StatusOr<bool> KeyStore::Load() {
  TL_ASSIGN_OR_RETURN(Files files, ReadFiles());
  if (files_ == files) return false;
  TL_ASSIGN_OR_RETURN(JwtKeySet keys, Parse(files));
  if (HoldsSecrets(keys)) WarnIfOthersMayRead(options_.path, log_);
  files_ = std::move(files);
  const auto shared = std::make_shared<const JwtKeySet>(std::move(keys));
  const absl::MutexLock lock(&mutex_);
  snapshot_ = {.keys = shared, .generation = snapshot_.generation + 1};
  return true;
}

void KeyStore::Poll() {
  const absl::StatusOr<bool> loaded = Load();
  const std::string error =
      loaded.ok() ? "" : std::string(loaded.status().message());
  if (log_ != nullptr && !error.empty() && error != last_error_) {
    log_(TrustSeverity::kWarning,
         absl::StrCat("new keys are not used, the old ones stay: ", error));
  }
  if (log_ != nullptr && loaded.ok() && *loaded) {
    log_(TrustSeverity::kInfo,
         absl::StrCat("keys of tokens read again from ", options_.path));
  }
  last_error_ = error;
}

KeyStore::Snapshot KeyStore::Current() {
  if (gate_.Enter(clock_.Now())) {
    Poll();
    gate_.Done();
  }
  const absl::MutexLock lock(&mutex_);
  return snapshot_;
}

}  // namespace treeline::access

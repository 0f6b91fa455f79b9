#include "client/relocalizer/token_source.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::relocalizer {
namespace {

// Far more than servers accept in a header.
constexpr uint64_t kMaxTokenBytes = 64 << 10;

// A header cannot carry other bytes, and no token has them.
bool IsTokenCharacter(char c) { return c > ' ' && c <= '~'; }

absl::StatusOr<std::string> CleanToken(absl::string_view text,
                                       absl::string_view source) {
  const absl::string_view token = absl::StripAsciiWhitespace(text);
  if (token.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": there is no token in it"));
  }
  if (!std::all_of(token.begin(), token.end(), IsTokenCharacter)) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": what it holds is not one token"));
  }
  return std::string(token.data(), token.size());
}

absl::StatusOr<std::string> ReadToken(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(path, kMaxTokenBytes));
  return CleanToken(text, path);
}

}  // namespace

bool TokenSource::FileState::operator==(const FileState& other) const {
  return device == other.device && inode == other.inode &&
         bytes == other.bytes && changed.tv_sec == other.changed.tv_sec &&
         changed.tv_nsec == other.changed.tv_nsec;
}

TokenSource::TokenSource(std::string path, std::string token)
    : path_(std::move(path)),
      state_(StateOf(path_)),
      token_(std::move(token)) {}

TokenSource::FileState TokenSource::StateOf(const std::string& path) {
  struct stat info = {};
  if (path.empty() || stat(path.c_str(), &info) != 0) return {};
  return {.device = info.st_dev,
          .inode = info.st_ino,
          .bytes = info.st_size,
          .changed = info.st_mtim};
}

absl::StatusOr<std::unique_ptr<TokenSource>> TokenSource::Open(
    const ConnectOptions& options) {
  if (!options.token_file.empty()) return FromFile(options.token_file);
  if (!options.token_variable.empty()) {
    return FromEnvironment(options.token_variable);
  }
  return nullptr;
}

absl::StatusOr<std::unique_ptr<TokenSource>> TokenSource::FromFile(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(std::string token, ReadToken(path));
  return std::unique_ptr<TokenSource>(new TokenSource(path, std::move(token)));
}

absl::StatusOr<std::unique_ptr<TokenSource>> TokenSource::FromEnvironment(
    const std::string& variable) {
  const char* value = std::getenv(variable.c_str());
  if (value == nullptr) {
    return absl::NotFoundError(
        absl::StrCat("the environment has no ", variable));
  }
  TL_ASSIGN_OR_RETURN(std::string token, CleanToken(value, variable));
  return std::unique_ptr<TokenSource>(new TokenSource("", std::move(token)));
}

std::string TokenSource::Get() {
  absl::MutexLock lock(&mutex_);
  if (path_.empty()) return token_;
  const FileState now = StateOf(path_);
  if (!(now == state_)) {
    // Read before the state is kept: a change in between is seen next time.
    absl::StatusOr<std::string> token = ReadToken(path_);
    if (token.ok()) {
      token_ = *std::move(token);
      state_ = now;
    }
  }
  return token_;
}

}  // namespace treeline::relocalizer

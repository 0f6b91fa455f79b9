#include "common/http/static_files.h"

#include <array>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::http {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFileBytes = uint64_t{64} << 20;
constexpr size_t kMaxPath = 1024;

absl::Status NoSuchFile() {
  return absl::NotFoundError("there is no such file");
}

// Letters, digits and what names of files need; nothing that a system reads as
// more than a name.
bool IsPlainName(absl::string_view name) {
  if (name.empty() || name[0] == '.') return false;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F || c == '\\' || c == '/') return false;
  }
  return true;
}

}  // namespace

std::string ContentTypeOf(absl::string_view path) {
  struct Type {
    absl::string_view ending;
    const char* type;
  };
  constexpr std::array<Type, 13> kTypes = {{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".map", "application/json"},
      {".webmanifest", "application/manifest+json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".jpg", "image/jpeg"},
      {".ico", "image/x-icon"},
      {".woff2", "font/woff2"},
      {".wasm", "application/wasm"},
  }};
  for (const Type& type : kTypes) {
    if (absl::EndsWith(path, type.ending)) return type.type;
  }
  return absl::EndsWith(path, ".txt") ? "text/plain; charset=utf-8"
                                      : "application/octet-stream";
}

absl::StatusOr<StaticFile> StaticFiles::Get(absl::string_view url_path) const {
  if (folder_.empty() || url_path.size() > kMaxPath ||
      !absl::StartsWith(url_path, "/")) {
    return NoSuchFile();
  }
  fs::path path = folder_;
  if (url_path == "/") {
    path /= "index.html";
  } else {
    const std::vector<std::string> names =
        absl::StrSplit(url_path.substr(1), '/');
    for (const std::string& name : names) {
      if (!IsPlainName(name)) return NoSuchFile();
      path /= name;
    }
  }
  // What a link leads to must lie in the folder too.
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  if (error) return NoSuchFile();
  const fs::path root = fs::canonical(folder_, error);
  if (error || !absl::StartsWith(real.string(), root.string() + "/") ||
      !fs::is_regular_file(real, error)) {
    return NoSuchFile();
  }
  TL_ASSIGN_OR_RETURN(std::string bytes,
                      base::ReadFile(real.string(), kMaxFileBytes));
  return StaticFile{ContentTypeOf(path.string()), std::move(bytes)};
}

bool StaticFiles::HasPage() const {
  std::error_code error;
  return !folder_.empty() &&
         fs::is_regular_file(fs::path(folder_) / "index.html", error);
}

std::string FindPageFolder(const std::string& name,
                           const std::string& built_folder) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  std::vector<fs::path> places;
  if (!error) {
    places.push_back(program.parent_path().parent_path() / "share/treeline" /
                     name);
  }
  places.emplace_back(built_folder);
  for (const fs::path& place : places) {
    if (StaticFiles(place.string()).HasPage()) return place.string();
  }
  return "";
}

}  // namespace treeline::http

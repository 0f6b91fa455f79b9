#include "server/app/failed_query_folder.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "server/app/failed_query_recorder.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::server_app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr char kJson[] = "application/json";
constexpr uint64_t kLargestJson = uint64_t{16} << 20;
constexpr uint64_t kLargestRequest = uint64_t{1} << 30;
constexpr int kJpegQuality = 90;

absl::Status NotKept(absl::string_view what) {
  return base::WithReason(absl::NotFoundError(what), "QUERY_NOT_KEPT");
}

// Of what is gone since it was listed: the oldest make room.
absl::StatusOr<std::string> Read(const std::string& path, uint64_t largest) {
  absl::StatusOr<std::string> bytes = base::ReadFile(path, largest);
  if (bytes.ok()) return bytes;
  // The path is not for everyone.
  if (absl::IsNotFound(bytes.status())) return NotKept("no such query is kept");
  return absl::UnavailableError("a file of the query cannot be read");
}

// "20261126T045537.608Z-..." -> "2026-11-26T04:55:37.608Z".
std::string TimeUtc(const std::string& name) {
  return absl::StrCat(name.substr(0, 4), "-", name.substr(4, 2), "-",
                      name.substr(6, 5), ":", name.substr(11, 2), ":",
                      name.substr(13, 7));
}

Json Entry(const std::string& name, const std::string& text) {
  Json entry{{"name", name}, {"time_utc", TimeUtc(name)}};
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return entry;
  for (const char* key : {"reason", "scene", "status", "trace_id"}) {
    const auto found = json.find(key);
    if (found != json.end() && found->is_string()) entry[key] = *found;
  }
  return entry;
}

absl::StatusOr<gateway::Content> JpegOf(const v1::Rgb8Image& raw) {
  const int64_t bytes = int64_t{3} * raw.width_px() * raw.height_px();
  if (raw.width_px() < 1 || raw.height_px() < 1 ||
      bytes != static_cast<int64_t>(raw.data().size())) {
    return NotKept("the query has no picture that can be shown");
  }
  image::ColorImage image{
      .width = raw.width_px(), .height = raw.height_px(), .rgb = {}};
  image.rgb.assign(raw.data().begin(), raw.data().end());
  TL_ASSIGN_OR_RETURN(std::string jpeg, image::EncodeJpeg(image, kJpegQuality));
  return gateway::Content{"image/jpeg", std::move(jpeg)};
}

}  // namespace

absl::StatusOr<gateway::Content> FailedQueryFolder::Get(
    absl::string_view path) const {
  if (path.empty()) return List();
  const bool is_picture = absl::ConsumeSuffix(&path, "/picture");
  const std::string name(path);
  if (!IsFailedQueryName(name)) return NotKept("no such query is kept");
  if (is_picture) return Picture(name);
  TL_ASSIGN_OR_RETURN(
      std::string json,
      Read(absl::StrCat(folder_, "/", name, ".json"), kLargestJson));
  return gateway::Content{kJson, std::move(json)};
}

absl::StatusOr<gateway::Content> FailedQueryFolder::List() const {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end;
       !error && entry != end; entry.increment(error)) {
    std::string name = entry->path().filename().string();
    // What is large comes last: where it is, everything is.
    if (!absl::EndsWith(name, ".binpb")) continue;
    name.resize(name.size() - 6);
    if (IsFailedQueryName(name)) names.push_back(std::move(name));
  }
  if (error) return absl::UnavailableError("the folder cannot be read");
  std::sort(names.begin(), names.end(), std::greater<>());
  Json queries = Json::array();
  for (const std::string& name : names) {
    if (queries.size() == kMostListed) break;
    const auto text =
        Read(absl::StrCat(folder_, "/", name, ".json"), kLargestJson);
    if (text.ok()) queries.push_back(Entry(name, *text));
  }
  return gateway::Content{kJson,
                          Json{{"queries", std::move(queries)}}.dump(
                              -1, ' ', true, Json::error_handler_t::replace)};
}

absl::StatusOr<gateway::Content> FailedQueryFolder::Picture(
    const std::string& name) const {
  TL_ASSIGN_OR_RETURN(
      const std::string bytes,
      Read(absl::StrCat(folder_, "/", name, ".binpb"), kLargestRequest));
  v1::LocalizeRequest request;
  if (!request.ParseFromString(bytes)) {
    return NotKept("the query has no picture that can be shown");
  }
  v1::ColorImage& color = *request.mutable_frame()->mutable_color();
  if (color.has_rgb8()) return JpegOf(color.rgb8());
  // Whatever else it is, no browser shall look at it.
  if (absl::StartsWith(color.encoded(), "\xff\xd8\xff")) {
    return gateway::Content{"image/jpeg", std::move(*color.mutable_encoded())};
  }
  if (absl::StartsWith(color.encoded(), "\x89PNG\r\n\x1a\n")) {
    return gateway::Content{"image/png", std::move(*color.mutable_encoded())};
  }
  return NotKept("the query has no picture that can be shown");
}

}  // namespace treeline::server_app

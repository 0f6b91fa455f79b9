#include "server/tools/publish.h"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/repository/names.h"
#include "server/repository/scene_metadata.h"
#include "server/repository/sha256.h"
#include "server/repository/web_url.h"

namespace treeline::tools {
namespace {

bool ComesFirst(const repository::ModelRef& a, const repository::ModelRef& b) {
  if (a.scene != b.scene) return a.scene < b.scene;
  return repository::VersionIsOlder(a.version, b.version);
}

}  // namespace

absl::Status PublishOptions::Validate() const {
  if (base_url.empty()) return absl::OkStatus();
  if (!absl::EndsWith(base_url, "/")) {
    return absl::InvalidArgumentError("--base-url must end with /");
  }
  return base::Annotate(repository::ResolveUrl("", base_url).status(),
                        "--base-url");
}

absl::StatusOr<repository::ModelIndex> IndexModels(
    repository::ModelSource& source, const PublishOptions& options,
    const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(repository::SourceListing listing, source.List());
  if (listing.models.empty()) {
    return absl::NotFoundError(
        "no models: nothing is called <scene>/<version>/model.treeline");
  }
  // A folder lists its entries in any order.
  std::sort(listing.models.begin(), listing.models.end(), ComesFirst);
  if (!listing.scene_json_errors.empty()) {
    const auto& [scene, error] = *listing.scene_json_errors.begin();
    return base::Annotate(error, absl::StrCat(scene, "/scene.json"));
  }
  repository::ModelIndex index;
  for (const auto& [scene, text] : listing.scene_json) {
    TL_RETURN_IF_ERROR(
        base::Annotate(repository::ParseSceneMetadata(text).status(),
                       absl::StrCat(scene, "/scene.json")));
    index.scene_json[scene] = text;
  }
  uint64_t total = 0;
  for (const repository::ModelRef& model : listing.models) total += model.bytes;
  base::Progress progress("hashing", static_cast<int64_t>(total),
                          options.quiet);
  for (const repository::ModelRef& model : listing.models) {
    TL_ASSIGN_OR_RETURN(const std::string path, source.Fetch(model, stop));
    TL_ASSIGN_OR_RETURN(
        repository::FileDigest digest,
        repository::DigestOfFile(path, stop, [&](uint64_t bytes) {
          progress.Add(static_cast<int64_t>(bytes));
        }));
    index.models.push_back(
        {.scene = model.scene,
         .version = model.version,
         .bytes = digest.bytes,
         .sha256 = std::move(digest.sha256),
         .url = absl::StrCat(options.base_url, model.scene, "/", model.version,
                             "/model.treeline")});
  }
  return index;
}

}  // namespace treeline::tools

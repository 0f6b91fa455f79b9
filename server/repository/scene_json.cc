#include "server/repository/scene_json.h"

#include "absl/strings/str_cat.h"

namespace treeline::repository {

SceneJson::File SceneJson::Of(const std::string& scene,
                              const SourceListing& listing) {
  const auto error = listing.scene_json_errors.find(scene);
  if (error != listing.scene_json_errors.end()) {
    return Unreadable{error->second.code()};
  }
  const auto text = listing.scene_json.find(scene);
  if (text != listing.scene_json.end()) return Text{text->second};
  return NoFile{};
}

SceneJson::Change SceneJson::Apply(const File& file) {
  if (file == file_) return {};
  file_ = file;
  if (const auto* text = std::get_if<Text>(&file)) return ApplyText(text->json);
  if (const auto* unreadable = std::get_if<Unreadable>(&file)) {
    // Without the message: it tells where the server keeps its files.
    problem_ = absl::InvalidArgumentError(
        absl::StrCat("scene.json: cannot be read: ",
                     absl::StatusCodeToString(unreadable->code)));
    return {.is_problem = true};
  }
  problem_ = absl::OkStatus();
  const bool had_metadata = metadata_ != nullptr;
  metadata_ = nullptr;
  return {.of_metadata = had_metadata};
}

SceneJson::Change SceneJson::ApplyText(const std::string& json) {
  const absl::StatusOr<SceneMetadata> parsed = ParseSceneMetadata(json);
  problem_ = parsed.status();
  if (!parsed.ok()) return {.is_problem = true};
  metadata_ = std::make_shared<const SceneMetadata>(*parsed);
  return {.of_metadata = true};
}

}  // namespace treeline::repository

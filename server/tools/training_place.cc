#include "server/tools/training_place.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"
#include "server/repository/names.h"

namespace treeline::tools {

absl::StatusOr<std::string> SceneOfMapBundle(const std::string& folder) {
  const std::string path = folder + "/bundle.yaml";
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return absl::NotFoundError(
        absl::StrCat(folder,
                     ": there is no complete map bundle (no bundle.yaml); "
                     "`treeline-agent map` makes one"));
  }
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode manifest,
                      yaml::YamlNode::Read(path));
  return manifest.Text("name");
}

absl::StatusOr<std::string> NextModelPath(const std::string& repository,
                                          const std::string& scene) {
  if (scene.empty()) {
    return absl::InvalidArgumentError(
        "which scene of the repository is it? Give --scene NAME");
  }
  TL_RETURN_IF_ERROR(repository::CheckName("--scene", scene));
  const std::string folder = absl::StrCat(repository, "/", scene);
  int highest = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    int version = 0;
    if (absl::SimpleAtoi(entry.path().filename().string(), &version)) {
      highest = std::max(highest, version);
    }
  }
  const std::string path =
      absl::StrCat(folder, "/", highest + 1, "/model.treeline");
  TL_RETURN_IF_ERROR(base::MakeParentFolder(path));
  return path;
}

void RemoveEmptyVersion(const std::string& model_path) {
  std::error_code ignored;
  const std::filesystem::path version =
      std::filesystem::path(model_path).parent_path();
  std::filesystem::remove(version, ignored);
  std::filesystem::remove(version.parent_path(), ignored);
}

}  // namespace treeline::tools

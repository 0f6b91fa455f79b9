// The index of a web server's models, as arbitrary bytes: no crash, and what
// is accepted holds what the header promises and survives being written.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "server/repository/model_index.h"
#include "server/repository/names.h"
#include "server/repository/sha256.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto index = treeline::repository::ParseModelIndex(
      absl::string_view(reinterpret_cast<const char*>(data), size));
  if (!index.ok()) return 0;
  for (const treeline::repository::IndexedModel& model : index->models) {
    if (!treeline::repository::IsValidName(model.scene) ||
        !treeline::repository::IsValidName(model.version) ||
        !treeline::repository::IsSha256(model.sha256) || model.bytes == 0 ||
        model.bytes > treeline::repository::kMaxModelBytes ||
        model.url.empty()) {
      std::abort();
    }
  }
  const auto text = treeline::repository::ModelIndexJson(*index);
  if (!text.ok()) std::abort();
  const auto again = treeline::repository::ParseModelIndex(*text);
  if (!again.ok() || again->models.size() != index->models.size() ||
      again->scene_json != index->scene_json) {
    std::abort();
  }
  return 0;
}

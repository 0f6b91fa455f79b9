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
  const auto index = treeline::ParseModelIndex(
      absl::string_view(reinterpret_cast<const char*>(data), size));
  if (!index.ok()) return 0;
  for (const treeline::IndexedModel& model : index->models) {
    if (!treeline::IsValidName(model.scene) ||
        !treeline::IsValidName(model.version) ||
        !treeline::IsSha256(model.sha256) || model.bytes == 0 ||
        model.bytes > treeline::kMaxModelBytes || model.url.empty()) {
      std::abort();
    }
  }
  const auto text = treeline::ModelIndexJson(*index);
  if (!text.ok()) std::abort();
  const auto again = treeline::ParseModelIndex(*text);
  if (!again.ok() || again->models.size() != index->models.size() ||
      again->scene_json != index->scene_json) {
    std::abort();
  }
  return 0;
}

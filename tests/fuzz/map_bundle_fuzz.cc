// The manifest of a map bundle.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "nav_agent/map_bundle/map_bundle.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto manifest =
      treeline::map_bundle::ParseMapBundleManifest(bytes, "fuzz");
  if (manifest.ok() &&
      (manifest->keyframes < 0 || !manifest->traversability.Validate().ok())) {
    std::abort();
  }
  return 0;
}

// Pictures of maps, and the maps of Wean Hall.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/recording/wean_map.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto picture = treeline::core::ParsePgm(bytes, "fuzz");
  if (picture.ok()) {
    // What was read is written and read again without a change.
    const auto again =
        treeline::core::ParsePgm(treeline::core::FormatPgm(*picture), "again");
    if (!again.ok() || again->values != picture->values) std::abort();
  }
  const auto map = treeline::recording::ParseWeanMap(bytes, "fuzz");
  if (map.ok() && map->cells.size() != static_cast<size_t>(map->width) *
                                           static_cast<size_t>(map->height)) {
    std::abort();
  }
  return 0;
}

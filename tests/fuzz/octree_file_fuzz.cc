// OctoMap files as arbitrary bytes: no crash, little memory, and what is read
// is written and read again alike.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "nav_agent/octomap/octree_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::octree::OctreeReadOptions options;
  options.max_bytes = 1 << 16;
  const auto map = treeline::octree::ParseOctree(
      absl::string_view(reinterpret_cast<const char*>(data), size), "fuzz",
      options);
  if (!map.ok()) return 0;
  const auto bytes = treeline::octree::FormatBt(*map);
  if (!bytes.ok()) std::abort();
  const auto again = treeline::octree::ParseOctree(*bytes, "again", options);
  if (!again.ok() || again->CountOccupied() != map->CountOccupied() ||
      again->CountFree() != map->CountFree()) {
    std::abort();
  }
  return 0;
}

// Zones as arbitrary bytes: a file of them is read or refused, and whatever
// polygon passes the check has cells of the map alone. An input is the text of
// a file; or, after a byte 1, kind, level, speed, direction and corners as they
// lie in memory.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "nav_agent/zones/zone.h"
#include "nav_agent/zones/zone_file.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline {
namespace {

class Bytes {
 public:
  Bytes(const uint8_t* data, size_t size) : data_(data), size_(size) {}
  size_t left() const { return size_; }
  double Number() {
    double value = 0;
    if (size_ < sizeof(value)) return 0;
    std::memcpy(&value, data_, sizeof(value));
    data_ += sizeof(value);
    size_ -= sizeof(value);
    return value;
  }

 private:
  const uint8_t* data_;
  size_t size_;
};

traversability::TraversableMap SmallMap() {
  traversability::TraversableLevel level;
  level.grid = core::OccupancyGrid::Filled(
      40, 30, 0.1, {.translation = {-1, 2}, .yaw_rad = 0.3},
      core::Occupancy::kFree);
  level.height_m.assign(level.grid.cells.size(), 0);
  level.slope_rad.assign(level.grid.cells.size(), 0);
  level.clearance_m.assign(level.grid.cells.size(), 3);
  traversability::TraversableMap map;
  map.levels.push_back(std::move(level));
  return map;
}

void CheckPolygon(const uint8_t* data, size_t size) {
  static const traversability::TraversableMap map = SmallMap();
  zones::Zone zone = {
      .name = "x",
      .kind = static_cast<zones::ZoneKind>(size == 0 ? 0 : data[0] % 3),
      .level = 0,
      .corners_in_map = {}};
  Bytes bytes(data, size);
  zone.max_mps = bytes.Number();
  zone.direction_rad = bytes.Number();
  while (bytes.left() >= 2 * sizeof(double) &&
         zone.corners_in_map.size() <= zones::kMaxZoneCorners) {
    const double x = bytes.Number();
    zone.corners_in_map.push_back({x, bytes.Number()});
  }
  if (!zones::CheckZone(zone, 1).ok()) return;
  const core::OccupancyGrid& grid = map.levels.front().grid;
  for (const size_t cell : zones::CellsOf(zone, grid)) {
    if (cell >= grid.cells.size()) std::abort();
  }
  const auto made = zones::ZoneMap::Make(map, {&zone, 1}, {}, 0.6);
  if (made.ok() && (*made)->empty()) std::abort();
  // What passes is kept bit for bit.
  const auto kept = zones::ParseZoneFile(zones::ZoneFileText({&zone, 1}));
  if (!kept.ok() || kept->size() != 1 || !(kept->front() == zone)) {
    // A speed or direction that its kind does not have need not be a number.
    if (std::isfinite(zone.max_mps) && std::isfinite(zone.direction_rad)) {
      std::abort();
    }
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > 0 && data[0] == 1) {
    treeline::CheckPolygon(data + 1, size - 1);
    return 0;
  }
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto zones = treeline::zones::ParseZoneFile(text);
  if (zones.ok() && zones->size() > text.size()) std::abort();
  return 0;
}

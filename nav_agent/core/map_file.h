// Maps as map_server keeps them: a YAML file beside a picture (PGM, PNG).
#ifndef NAV_AGENT_CORE_MAP_FILE_H_
#define NAV_AGENT_CORE_MAP_FILE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"

namespace treeline::core {

// Maps above this many cells are refused.
inline constexpr int64_t kMaxMapCells = int64_t{1} << 28;

// A picture of grey levels, rows from the top.
struct GreyPicture {
  int width = 0;
  int height = 0;
  int max_value = 255;  // of `values`; what is white
  std::vector<uint16_t> values;
};

// PGM, plain (P2) or raw (P5), of 8 or 16 bits. INVALID_ARGUMENT, with `name`
// in front, for what is not. Safe on any bytes; memory is at most a small
// multiple of them.
absl::StatusOr<GreyPicture> ParsePgm(absl::string_view bytes,
                                     absl::string_view name);
std::string FormatPgm(const GreyPicture& picture);

// Reads the map whose YAML file is at `path`: keys image, resolution, origin
// [x, y, yaw], negate, occupied_thresh, free_thresh, and mode (trinary, scale
// or raw; map_server's documentation). The picture is PGM or PNG: of colours
// the mean counts, as there; what is transparent does not count as unknown. In
// mode scale what is neither occupied nor free is unknown too. Errors name file
// and line.
absl::StatusOr<OccupancyGrid> ReadMap(const std::string& path);

// What map_server makes of each pixel: the occupancy, 0 to 100, or nothing.
// Rows from the bottom, as OccupancyGrid has them.
struct ValueGrid {
  int width = 0;
  int height = 0;
  double resolution_m = 0.05;
  // The grid's frame in the map.
  geometry::Rigid2 map_from_grid;
  // 255: none.
  std::vector<uint8_t> values;

  bool Contains(CellIndex cell) const {
    return cell.x >= 0 && cell.x < width && cell.y >= 0 && cell.y < height;
  }
  std::optional<int> At(CellIndex cell) const {
    const uint8_t value =
        values[static_cast<size_t>(cell.y) * static_cast<size_t>(width) +
               static_cast<size_t>(cell.x)];
    return value > 100 ? std::nullopt : std::optional<int>(value);
  }
};

// The same file as values, for masks: in mode trinary 100 is occupied, 0 free;
// in mode scale what is between the thresholds is in proportion; in mode raw
// the pixel is the value (map_server's documentation).
absl::StatusOr<ValueGrid> ReadMapValues(const std::string& path);

// Writes the map as PATH and, beside it, as a picture of the same name that
// ends in .pgm: free is 254, occupied 0, unknown 205. Each file is replaced
// atomically. INVALID_ARGUMENT if `path` does not end in .yaml.
absl::Status WriteMap(const OccupancyGrid& grid, const std::string& path);

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_MAP_FILE_H_

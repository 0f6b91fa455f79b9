// Maps of the course data of Wean Hall (CMU 16-831).
#ifndef NAV_AGENT_RECORDING_WEAN_MAP_H_
#define NAV_AGENT_RECORDING_WEAN_MAP_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/core/occupancy_grid.h"

namespace treeline::recording {

// Reads "global_map[0]: ROWS COLUMNS" and as many numbers; the lines before it
// may state "robot_specifications->resolution" (cm; 10 where they do not). Rows
// of the file run along x, columns along y. Numbers are the probability that a
// cell is FREE, -1 where nothing is known: the data's own description says
// "occupied", and its picture the contrary. Above 0.8 is free, below 0.2
// occupied, the rest unknown. May be compressed (gzip).
//
// The errors of ReadFile, or INVALID_ARGUMENT with what is wrong.
absl::StatusOr<core::OccupancyGrid> ReadWeanMap(const std::string& path);
// The same for bytes in memory, called `name` in errors. Safe on any bytes.
absl::StatusOr<core::OccupancyGrid> ParseWeanMap(absl::string_view bytes,
                                                 const std::string& name);

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_WEAN_MAP_H_

// What somebody who drives on a map of map_server may not have meant.
#ifndef NAV_AGENT_CORE_DOUBTFUL_MAP_H_
#define NAV_AGENT_CORE_DOUBTFUL_MAP_H_

#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"

namespace treeline::core {

struct DoubtfulMap {
  OccupancyGrid grid;
  // Text for people; empty: there is nothing.
  std::string doubt;
};

// ReadMap (nav_agent/core/map_file.h), with what is doubtful about the file:
// grey of unknown ground that its thresholds make free, and keys that are not
// known (map_server passes over them, too).
absl::StatusOr<DoubtfulMap> ReadDoubtfulMap(const std::string& path);

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_DOUBTFUL_MAP_H_

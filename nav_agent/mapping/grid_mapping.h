// An occupancy grid from scans whose places are known.
#ifndef NAV_AGENT_MAPPING_GRID_MAPPING_H_
#define NAV_AGENT_MAPPING_GRID_MAPPING_H_

#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::mapping {

struct GridMappingOptions {
  double resolution_m = 0.05;
  // Beams are marked up to here; what returns from farther only clears (m).
  double max_range_m = 15;
  // A beam without a return clears up to here; 0: it says nothing, as scanners
  // do not tell glass and black things from empty space (m).
  double no_return_clears_m = 0;
  // A cell is known once this many beams have met it, and occupied if at least
  // this part of them ended there (Haehnel's counting model).
  int min_beams = 2;
  double occupied_part = 0.25;
  // Around what was seen (m).
  double border_m = 0.5;

  absl::Status Validate() const;
};

struct GridScan {
  geometry::Rigid2 map_from_laser;
  std::span<const float> ranges_m;
};

// Free where beams passed, occupied where they ended. The grid's axes are the
// map's. INVALID_ARGUMENT for options, scans of other sizes than the laser's,
// or if there is nothing to see; RESOURCE_EXHAUSTED for a map of more cells
// than map_file.h allows.
absl::StatusOr<core::OccupancyGrid> MapGrid(std::span<const GridScan> scans,
                                            const core::RangeSensorInfo& laser,
                                            const GridMappingOptions& options);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_GRID_MAPPING_H_

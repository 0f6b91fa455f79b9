// Scans and grids.
#ifndef NAV_AGENT_BRIDGE_AGENT_VALUES_LASER_VALUES_H_
#define NAV_AGENT_BRIDGE_AGENT_VALUES_LASER_VALUES_H_

#include <string>

#include "absl/status/statusor.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::agent_values {

// INVALID_ARGUMENT for angles or limits that are none, and for no beams.
absl::StatusOr<core::RangeSensorInfo> SensorInfoOf(
    const messages::LaserScan& scan);
// Ranges outside of range_min and range_max are made what REP 117 says.
core::LaserScan ScanOf(const messages::LaserScan& scan);
messages::LaserScan MessageOf(const core::LaserScan& scan,
                              const core::RangeSensorInfo& info,
                              const std::string& frame_id);

// As Nav2's map server takes values: at least 65 is occupied, at most 25 free,
// anything else unknown. INVALID_ARGUMENT for sizes and numbers that do not
// fit.
absl::StatusOr<core::OccupancyGrid> GridOf(const messages::OccupancyGrid& grid);
messages::OccupancyGrid MessageOf(const core::OccupancyGrid& grid,
                                  const messages::Header& header);

}  // namespace treeline::agent_values

#endif  // NAV_AGENT_BRIDGE_AGENT_VALUES_LASER_VALUES_H_

// Where a scan's beams ended, each from where the robot was at its time.
#ifndef NAV_AGENT_MAPLESS_SCAN_BEAMS_H_
#define NAV_AGENT_MAPLESS_SCAN_BEAMS_H_

#include <vector>

#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/mapless/dead_reckoning.h"
#include "nav_agent/mapless/evidence_grid.h"

namespace treeline::mapless {

// Those with a range, up to max_range_m: a beam that goes further ends there
// and is left out. Empty where the robot's pose of then is not known.
std::vector<GridBeam> BeamsOf(const core::LaserScan& scan,
                              const core::RangeSensorInfo& laser,
                              const geometry::Rigid3& base_from_laser,
                              const DeadReckoning& reckoning,
                              double max_range_m);

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_SCAN_BEAMS_H_

// The way of a drive by wheels, before and after, and by scans.
#ifndef NAV_AGENT_CALIBRATION_TRAJECTORIES_H_
#define NAV_AGENT_CALIBRATION_TRAJECTORIES_H_

#include <vector>

#include "nav_agent/calibration/calibration.h"

namespace treeline::calibration {

// Places of the base at the ends of the stretches, in the frame of the first.
// Across what was not measured (standing, gaps, scans that do not match) all
// three follow wheels: `by_scans` the calibrated ones; the robot is taken to
// have stood where there are none.
struct Trajectories {
  std::vector<geometry::Vec2> before;
  std::vector<geometry::Vec2> after;
  std::vector<geometry::Vec2> by_scans;
};
Trajectories TrajectoriesOf(const Drive& drive, const Calibration& calibration);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_TRAJECTORIES_H_

// A navigator for a robot that has no map, or only a part of one: it drives to
// goals through what it sees.
#ifndef NAV_AGENT_MAPLESS_MAPLESS_NAVIGATOR_H_
#define NAV_AGENT_MAPLESS_MAPLESS_NAVIGATOR_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::mapless {

struct MaplessOptions {
  // At most the robot's own; 0: the robot's own ([0, 5] m/s).
  double max_forward_mps = 0;
  // From the goal, and of its heading ((0, 2] m, (0, 3.2] rad).
  double goal_tolerance_m = 0.10;
  double goal_tolerance_rad = 0.15;
  // Whether it turns to the goal's heading at last.
  bool turns_at_goal = true;
  // Steps in a second (10 to 200).
  double control_hz = 40;
  // Devices that are silent for longer are lost (s, 0.05 to 5).
  double laser_timeout_s = 0.3;
  double odometry_timeout_s = 0.2;
  // Beams are noted up to here (m, [1, 100]).
  double max_range_m = 10;
  // A goal without progress for so long fails (s, [1, 600]).
  double patience_s = 30;
  // As NavigatorOptions (s, [0.001, 1000]).
  double manual_lease_s = behavior::kManualLease_s;
  // What is known already, in the map's frame; occupied cells are obstacles
  // until they are seen free.
  std::vector<core::OccupancyGrid> known = {};

  absl::Status Validate() const;
};

// The map's frame is that of the base where it began, or what SetPose says;
// poses are the odometry's, and never jump: there is nothing to be lost in. All
// that the lasers see enters an EvidenceGrid, ways are planned on it
// (WayField), several times a second and kept unless another is clearly better,
// and followed by trying commands out (RolloutController). For level ground.
// camera and server of the devices are not used. Errors as Navigator::Create.
absl::StatusOr<std::unique_ptr<behavior::Navigator>> MakeMaplessNavigator(
    const core::RobotModel& robot, const behavior::NavigatorDevices& devices,
    const MaplessOptions& options, const base::Clock& clock);

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_MAPLESS_NAVIGATOR_H_

// A map of one floor (nav_msgs/OccupancyGrid) as a witness for or against a
// place: free ground, and what the laser should see.
#ifndef NAV_AGENT_BRIDGE_PLACE_FINDER_FLAT_MAP_H_
#define NAV_AGENT_BRIDGE_PLACE_FINDER_FLAT_MAP_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/behavior/fix_gate.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/localization/lost_scan_check.h"
#include "nav_agent/localization/scan_fit.h"

namespace treeline::place_finder {

// A scan, by which laser it was taken, and how the robot leaned.
struct PlacedScan {
  core::LaserScan scan;
  core::RangeSensorInfo info;
  geometry::Rigid3 base_from_laser;
  // In the middle of it, by the wheels.
  geometry::Rigid2 odom_from_base;
  double pitch_rad = 0;
  double roll_rad = 0;
};

// Immutable and thread-safe.
class FlatMap {
 public:
  static absl::StatusOr<FlatMap> Make(core::OccupancyGrid grid);

  const core::OccupancyGrid& grid() const { return grid_; }
  // To the nearest obstacle (m, at most 2); 0 on what is not free.
  double Clearance_m(geometry::Vec2 point_in_map) const;
  // nullopt: the scan says nothing.
  std::optional<localization::ScanFit> FitOf(
      const PlacedScan& scan, const geometry::Rigid2& map_from_base) const;
  // The place within the gate's search_m and search_rad where it fits best;
  // moving and turning cost what they cost the agent's own fixes.
  std::optional<localization::FittedPose> BestNear(
      const PlacedScan& scan, const geometry::Rigid2& map_from_base,
      const behavior::FixGateOptions& gate) const;

 private:
  FlatMap(core::OccupancyGrid grid, localization::ScanChecker checker);

  core::OccupancyGrid grid_;
  localization::ScanChecker checker_;
  std::vector<float> distances_m_;
};

}  // namespace treeline::place_finder

#endif  // NAV_AGENT_BRIDGE_PLACE_FINDER_FLAT_MAP_H_

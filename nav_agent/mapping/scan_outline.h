// A laser scan as points and pieces of surface.
#ifndef NAV_AGENT_MAPPING_SCAN_OUTLINE_H_
#define NAV_AGENT_MAPPING_SCAN_OUTLINE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::mapping {

struct ScanOutlineOptions {
  // Farther returns are not used: what they hit is small, and where they hit
  // it depends on small turns and on how level the robot stands (m, above 0).
  double max_range_m = 25;
  // Neighbouring returns of one surface are averaged over this length of it, so
  // that a wall beside the robot weighs no more than one ahead (m, 0 or more).
  double spacing_m = 0.03;
  // Neighbouring returns are of one surface if they are at most this far
  // apart (m), and it is seen at an angle of at least this (rad).
  double max_join_m = 0.5;
  double min_incidence_rad = 0.14;
  // Points above the ground that the robot stands on outside of these heights
  // are dropped: floor or ceiling, seen by a robot that is not level (m).
  double min_height_m = -1e9;
  double max_height_m = 1e9;

  absl::Status Validate() const;
};

// In the robot's levelled frame: its origin and yaw are those of the base, its
// z is up. joined[i] says that a surface runs from point i to point i + 1.
struct ScanOutline {
  std::vector<geometry::Vec2> points_m;
  std::vector<uint8_t> joined;
  // Where the laser was.
  geometry::Vec2 seen_from = {};

  size_t size() const { return points_m.size(); }
  bool empty() const { return points_m.empty(); }
};

// The valid returns of a scan. level_from_laser has the base's roll and pitch
// in it, and the laser's mount: on level ground it is base_from_laser.
// ranges_m: one for each beam of `laser`; what is not finite or outside of the
// laser's range is no return.
// first_from_last is how the robot moved from the first beam to the last:
// points are put where they would have been seen at the time of the first.
ScanOutline MakeScanOutline(std::span<const float> ranges_m,
                            const core::RangeSensorInfo& laser,
                            const geometry::Rigid3& level_from_laser,
                            const ScanOutlineOptions& options = {},
                            const geometry::Rigid2& first_from_last = {});

// Every so many of its points, each on its own.
ScanOutline Thinned(const ScanOutline& scan, size_t every);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SCAN_OUTLINE_H_

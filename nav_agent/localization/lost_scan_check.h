// Which beams of a scan a map explains, seen from a pose: what lost detection
// begins with.
#ifndef NAV_AGENT_LOCALIZATION_LOST_SCAN_CHECK_H_
#define NAV_AGENT_LOCALIZATION_LOST_SCAN_CHECK_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/scan_points.h"

namespace treeline::localization {

enum class BeamFit : uint8_t {
  // It ends near an obstacle of the map that it should meet.
  kExplained,
  // It ends before it gets to one: something is there that the map does not
  // have.
  kShort,
  // It passes through an obstacle of the map: that is gone, or the robot is
  // not where it thinks it is.
  kLong,
  // It says nothing: no return, the ground, or a place that the map does not
  // know.
  kNotJudged
};

struct CheckedBeam {
  BeamFit fit = BeamFit::kNotJudged;
  // Where it ends, in the frame of the base when that is level (m).
  geometry::Vec2 end_in_base;
  // From there to the nearest obstacle of the map (m), at most field_reach_m.
  double distance_m = 0;
};

struct ScanCheckOptions {
  // So many beams at most, evenly spread; [8, 2000].
  int max_beams = kCheckedBeams;
  // A range may differ from what the map says by tolerance_m and this share of
  // it; [0.01, 2], [0, 0.5].
  double tolerance_m = kRangeTolerance_m;
  double tolerance_share = kRangeToleranceShare;
  // Obstacles nearer than this to the laser are not looked at; [0, 2].
  double nearest_m = kMinCheckRange_m;
  // Of the distance field; [0.1, 20].
  double field_reach_m = kFieldReach_m;
  // What ends lower than this above the ground that the robot stands on, as it
  // is tilted, may be ground (m); [0, 1].
  double ground_m = kGroundEnd_m;
  // Beams say nothing of what is so much higher or lower than the laser, as
  // the robot is tilted (m); [0.01, 5].
  double height_tolerance_m = kHeightTolerance_m;

  absl::Status Validate() const;
};

// How the robot stands and where its laser is.
struct ScanPose {
  geometry::Rigid2 map_from_base;
  // Nose down and right side down are positive.
  double pitch_rad = 0;
  double roll_rad = 0;
};

// A level as the laser sees it.
struct LaserMap {
  // Occupied: where beams end, from some place or other.
  core::OccupancyGrid map;
  // The same, but occupied only where next to no beam ever went through when
  // the map was made: not at the edges of platforms, which a robot on top looks
  // over, nor at panes of glass. Beams that pass through other cells prove
  // nothing. The same size and place as `map`.
  core::OccupancyGrid opaque;

  // Where nothing is known of that.
  static LaserMap AllOpaque(const core::OccupancyGrid& map) {
    return {map, map};
  }
};

// Where at most max_points beams of a robot that stands tilted end, in the
// frame of its base when that is level: those that end at about the height of
// the laser. Localization on a plane wants these.
absl::StatusOr<ScanPoints> PointsAtLaserHeight(
    const core::LaserScan& scan, const core::RangeSensorInfo& info,
    const geometry::Rigid3& base_from_laser, double pitch_rad, double roll_rad,
    int max_points, const ScanCheckOptions& options);

// Immutable and thread-safe; ten bytes a cell.
class ScanChecker {
 public:
  // INVALID_ARGUMENT for bad options, maps without cells, and maps that differ
  // in size.
  static absl::StatusOr<ScanChecker> Create(const LaserMap& map,
                                            const ScanCheckOptions& options);

  // In order of the beams. A range is compared with those that the map has for
  // the beam and its neighbours, so that a pose that is a little wrong does
  // not move beams past edges. INVALID_ARGUMENT if the scan has another number
  // of beams than `info` says, or the pose is not finite.
  absl::StatusOr<std::vector<CheckedBeam>> Check(
      const ScanPose& pose, const core::RangeSensorInfo& info,
      const geometry::Rigid3& base_from_laser,
      const core::LaserScan& scan) const;

  // From a point of the map to the first opaque obstacle along a direction
  // (unit length), at most max_m; `is_known` is false if the way leaves what
  // the map knows before that.
  struct Ray {
    double range_m = 0;
    bool is_known = true;
  };
  Ray Cast(geometry::Vec2 from_in_map, geometry::Vec2 direction_in_map,
           double max_m) const;

  // The distance to the nearest obstacle.
  double DistanceAt_m(geometry::Vec2 point_in_map) const;

  const ScanCheckOptions& options() const { return options_; }

 private:
  ScanChecker(const LaserMap& map, const ScanCheckOptions& options);

  ScanCheckOptions options_;
  core::OccupancyGrid opaque_;
  geometry::Rigid2 grid_from_map_;
  // To what is occupied in the map, and to what is opaque.
  std::vector<float> distances_m_;
  std::vector<float> opaque_distances_m_;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_LOST_SCAN_CHECK_H_

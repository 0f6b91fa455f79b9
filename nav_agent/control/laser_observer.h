// What one planar laser shows around the robot.
#ifndef NAV_AGENT_CONTROL_LASER_OBSERVER_H_
#define NAV_AGENT_CONTROL_LASER_OBSERVER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/ground_layer.h"
#include "nav_agent/control/observed_point.h"
#include "nav_agent/control/obstacle_layer.h"
#include "nav_agent/control/thing_column.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// Takes scans into an ObstacleLayer: a beam's end marks if it is at the height
// of an obstacle (GroundLayer::IsHeightOfObstacle) and a neighbouring beam ends
// beside it; what beams passed on their way is cleared. Each beam starts from
// where the robot was at its time. Not thread-safe.
class LaserObserver {
 public:
  // Beams are used up to reach_m.
  LaserObserver(const core::RangeSensorInfo& info,
                const geometry::Rigid3& base_from_laser, double robot_height_m,
                double reach_m);

  // INVALID_ARGUMENT: the number of ranges is not that of the beams.
  absl::Status Check(const core::LaserScan& scan) const;
  // A scan that was checked, from a finite pose at its first beam.
  void Add(const ControlPose& pose, const core::LaserScan& scan,
           const CostmapWindow& window, const GroundLayer& ground,
           int64_t now_ms, ObstacleLayer& obstacles);
  void ForgetPoints() { points_.clear(); }

  // What the newest scan shows of a column: kThrough if all beams towards it
  // end beyond it and pass it at the height of things that stand.
  LaserSight Look(const ThingColumn& column) const;

  // The newest scan's points on obstacles, the map's included, near the robot.
  std::span<const ObservedPoint> points() const { return points_; }
  std::optional<base::MonotonicTime> last_scan() const { return last_scan_; }
  // One of the points that move is of the same body as this place.
  bool ShowsMoverNear(geometry::Vec2 in_map) const;

 private:
  // Where the beams end, in the map, later ones from where the robot was then.
  std::vector<geometry::Vec3> EndsOf(
      const ControlPose& pose, const core::LaserScan& scan,
      const geometry::Rigid3& map_from_laser) const;
  double RangeOf_m(const core::LaserScan& scan, size_t beam) const;

  core::RangeSensorInfo info_;
  geometry::Rigid3 base_from_laser_;
  double robot_height_m_;
  double reach_m_;
  std::vector<double> beam_cos_;
  std::vector<double> beam_sin_;
  std::optional<base::MonotonicTime> last_scan_;
  std::vector<ObservedPoint> points_;
  // Of the newest scan: whence, and where its beams end; those without return
  // where they begin.
  geometry::Rigid3 map_from_laser_;
  std::vector<geometry::Vec3> ends_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_LASER_OBSERVER_H_

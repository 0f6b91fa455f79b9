// What stands around the robot: the map's ground, and what its sensors see.
#ifndef NAV_AGENT_CONTROL_LOCAL_COSTMAP_H_
#define NAV_AGENT_CONTROL_LOCAL_COSTMAP_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/depth_observer.h"
#include "nav_agent/control/distance_layer.h"
#include "nav_agent/control/gone_things.h"
#include "nav_agent/control/ground_layer.h"
#include "nav_agent/control/laser_observer.h"
#include "nav_agent/control/observed_obstacles.h"
#include "nav_agent/control/observed_point.h"
#include "nav_agent/control/obstacle_layer.h"
#include "nav_agent/control/setting_parameters.h"
#include "nav_agent/control/zone_layer.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::control {

struct LocalCostmapOptions {
  // Along the map's x and y (m, 1 to 20), and of a cell (m, 0.01 to 0.2).
  double length_m = kCostmapSize_m;
  double width_m = kCostmapSize_m;
  double resolution_m = kCostmapResolution_m;

  absl::Status Validate() const;
};

// kMapObstacle: zones that are kept out of, too.
enum class LocalCell : uint8_t { kFree = 0, kMapObstacle = 1, kSeen = 2 };

// A window that rolls along with the robot, in layers that know nothing of each
// other's making:
//
//   GroundLayer     the map's ground that continues the robot's own
//   GoneThings      of what the map has, what is seen through: ground, too
//   ZoneLayer       what the robot is kept out of
//   ObstacleLayer   what sensors have hit and passed
//   LaserObserver,     from scans and frames into the ObstacleLayer
//   DepthObserver
//   DistanceLayer   distances to what any layer has
//
// This class gives them all the same window, pose and time. Sensors' data may
// come between steps; questions are answered as of the last Update.
//
// Deterministic; not thread-safe.
class LocalCostmap {
 public:
  // INVALID_ARGUMENT: bad options or measures, no map, or a laser that has not
  // said yet what it measures.
  static absl::StatusOr<LocalCostmap> Make(
      std::shared_ptr<const traversability::NavigationMap> map,
      const core::RobotModel& robot, const core::RobotLasers& lasers,
      const LocalCostmapOptions& options);

  // The window moves with the robot.
  void MoveTo(const ControlPose& pose);
  // INVALID_ARGUMENT: the number of beams is not the laser's, there is no such
  // laser, or the pose is not finite.
  absl::Status AddScan(const ControlPose& pose, const core::LaserScan& scan,
                       core::LaserMount mount = core::LaserMount::kFront);
  absl::Status AddDepth(const ControlPose& pose, const core::RgbdFrame& frame);
  void ClearObstacles();
  // As ZoneLayer's; right after the next Update.
  void SetZones(std::shared_ptr<const zones::ZoneMap> zones);
  // Forgets what is too old; distances are right afterwards.
  void Update(base::MonotonicTime now);

  // What of the map was seen to be gone; null: nothing.
  const std::shared_ptr<const traversability::FreedCells>& freed() const {
    return gone_.freed();
  }

  const CostmapWindow& window() const { return window_; }
  bool Contains(geometry::Vec2 point_in_map, double inset_m = 0) const {
    return window_.Contains(point_in_map, inset_m);
  }
  // One a cell of the window.
  const std::vector<LocalCell>& cells() const { return cells_; }
  const std::vector<float>& distances_m() const {
    return distances_.distances_m();
  }
  LocalCell CellAt(geometry::Vec2 point_in_map) const;

  // As DistanceLayer's.
  double Distance_m(geometry::Vec2 point_in_map) const {
    return distances_.Distance_m(point_in_map);
  }
  geometry::Vec2 Away(geometry::Vec2 point_in_map) const {
    return distances_.Away(point_in_map);
  }
  double FootprintDistance_m(const geometry::Rigid2& map_from_base,
                             double max_distance_m) const {
    return distances_.FootprintDistance_m(map_from_base, max_distance_m);
  }
  // The ground there, if it continues the robot's.
  std::optional<core::LevelPlace> GroundAt(geometry::Vec2 point_in_map) const;
  // What speed zones allow there; infinite where nothing does (m/s).
  double MaxSpeed_mps(geometry::Vec2 point_in_map) const;

  // As the functions of observed_obstacles.h, and GroundLayer's with the edges
  // of what is kept out of.
  ObservedObstacle ObstacleNear(geometry::Vec2 point_in_map, double reach_m,
                                base::MonotonicTime now) const;
  std::vector<RememberedObstacle> UnseenObstacles(
      geometry::Vec2 at, double radius_m, base::MonotonicTime now) const;
  std::vector<geometry::Vec2> MapObstacles(const core::LevelPose& pose,
                                           double radius_m) const;

  // The newest scan's and the newest frame's points on obstacles, the map's
  // included, near the robot. Of a laser that is not there: none.
  std::span<const ObservedPoint> scan_points(
      core::LaserMount mount = core::LaserMount::kFront) const;
  std::span<const ObservedPoint> depth_points() const {
    return depth_.points();
  }
  std::optional<base::MonotonicTime> last_scan(
      core::LaserMount mount = core::LaserMount::kFront) const;
  std::optional<base::MonotonicTime> last_depth() const {
    return depth_.last_frame();
  }

 private:
  LocalCostmap(std::shared_ptr<const traversability::NavigationMap> map,
               const core::RobotModel& robot, const core::RobotLasers& lasers,
               const LocalCostmapOptions& options);

  // Of the lasers whose newest scan is of about this time: pictures come later.
  LaserSight LookByLasers(const ThingColumn& column,
                          base::MonotonicTime stamp) const;
  // nullptr: there is none.
  const LaserObserver* SightOf(core::LaserMount mount) const;
  // Since the first time that it was told; 0 if it was told none.
  int64_t SinceEpoch_ms(base::MonotonicTime time) const;
  int64_t BeginEpoch_ms(base::MonotonicTime time);

  // Further than any distance in the window (m).
  double far_m_;
  double map_resolution_m_;
  core::RobotModel robot_;
  CostmapWindow window_;
  // The robot's pose when the ground was spread; none: it has to be.
  std::optional<core::LevelPose> placed_at_;
  // Of a robot that is lost: the slope that it stood on then (m/m).
  geometry::Vec2 placed_rise_;
  GoneThings gone_;
  GroundLayer ground_;
  ZoneLayer zones_;
  ObstacleLayer obstacles_;
  LaserObserver front_;
  std::optional<LaserObserver> rear_;
  DepthObserver depth_;
  // As of the last Update.
  std::vector<LocalCell> cells_;
  DistanceLayer distances_;
  std::optional<base::MonotonicTime> epoch_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_LOCAL_COSTMAP_H_

// From a path and what the sensors see to a velocity: local costmap, elastic
// band, speeds along it (thesis 6.5).
#ifndef NAV_AGENT_CONTROL_LOCAL_CONTROLLER_H_
#define NAV_AGENT_CONTROL_LOCAL_CONTROLLER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/control/close_approach.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/regulator_switches.h"
#include "nav_agent/control/setting_parameters.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/traversability/loose_things.h"
#include "nav_agent/traversability/navigation_map.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline::control {

struct LocalControllerOptions {
  // The costmap around the robot, forward x sideways of the map's axes (m).
  double costmap_length_m = kCostmapSize_m;
  double costmap_width_m = kCostmapSize_m;
  double costmap_resolution_m = kCostmapResolution_m;
  // Room beside the footprint that the band keeps where there is room (m).
  double inflation_m = kInflation_m;
  double goal_tolerance_m = kGoalTolerance_m;
  double goal_tolerance_rad = kGoalToleranceAngle_rad;
  double max_forward_mps = kMaxForward_mps;
  VelocityRegulatorSwitches regulators;

  absl::Status Validate() const;
};

enum class ControlState : uint8_t {
  kIdle,  // no path
  kDriving,
  kArrived,  // at the goal, standing
  kWaiting,  // something moves in the way; the band holds
  kBlocked   // the band is broken: a plan around what stands there is needed
};

struct Bubble {
  geometry::Vec2 center_in_map;
  double heading_rad = 0;
  double radius_m = 0;
};

struct ControlResult {
  ControlState state = ControlState::kIdle;
  core::VelocityCommand command;
  // If blocked: where, and how large what stands there is.
  geometry::Vec2 obstacle_in_map;
  double obstacle_radius_m = 0;
  // The collision stop had a say.
  bool is_stopped_by_guard = false;
  // Along the path still to go (m).
  double to_go_m = 0;
};

// For pictures: rows from the bottom, origin at the lower left corner.
struct CostmapView {
  geometry::Vec2 origin_in_map;
  double resolution_m = 0.05;
  int width = 0;
  int height = 0;
  // 0 free, 1 obstacle of the map or kept out of, 2 obstacle that was seen.
  std::vector<uint8_t> cells;
  // To the nearest obstacle (m).
  std::vector<float> distance_m;
};

// Deterministic, without clock, threads or files: time comes with what is
// given. Not thread-safe.
class LocalController {
 public:
  static absl::StatusOr<std::unique_ptr<LocalController>> Make(
      std::shared_ptr<const traversability::NavigationMap> map,
      const core::RobotModel& robot, const core::RobotLasers& lasers,
      const LocalControllerOptions& options);
  virtual ~LocalController() = default;

  // What was seen from `pose`, the robot's at that time.
  virtual absl::Status AddScan(const ControlPose& pose,
                               const core::LaserScan& scan) = 0;
  // The same of the laser that looks back; INVALID_ARGUMENT if there is none.
  virtual absl::Status AddRearScan(const ControlPose& pose,
                                   const core::LaserScan& scan) = 0;
  virtual absl::Status AddDepth(const ControlPose& pose,
                                const core::RgbdFrame& frame) = 0;
  // Forgets all that was seen (a recovery; the robot was told where it is).
  virtual void ClearObstacles() = 0;
  // Of the controller's map; null: none.
  virtual void SetZones(std::shared_ptr<const zones::ZoneMap> zones) = 0;

  // A new path; replaces what there is. Empty: none.
  virtual void SetPath(const std::vector<core::LevelPose>& path) = 0;
  // 40 times a second. The command obeys all limits, those of acceleration
  // from pose.forward_mps and yaw_rate_radps on.
  virtual ControlResult Step(const ControlPose& pose) = 0;

  // For recoveries: the command as near to `wanted` as limits and obstacles
  // allow; the last thing between any command and the base.
  virtual core::VelocityCommand Guard(const ControlPose& pose,
                                      const core::VelocityCommand& wanted) = 0;
  // The same for a robot that drives up to a thing: of what is seen of it, no
  // more room is kept than not to touch it.
  virtual core::VelocityCommand GuardUpTo(
      const CloseApproach& approach, const ControlPose& pose,
      const core::VelocityCommand& wanted) = 0;
  // Whether the footprint can turn fully, or move so far ahead (negative:
  // back), without touching what is known.
  virtual bool CanTurn(const ControlPose& pose) const = 0;
  virtual double FreeWay_m(const ControlPose& pose,
                           double max_distance_m) const = 0;
  // For how long nobody has been seen to move nearby (s): where people are
  // about, one may come up behind the robot, where no sensor looks. Infinity
  // for a robot with a laser there.
  virtual double QuietFor_s(base::MonotonicTime now) const = 0;

  // What of the map was seen to be gone, for plans; null: nothing.
  virtual std::shared_ptr<const traversability::FreedCells> Freed() const = 0;

  virtual std::vector<Bubble> Bubbles() const = 0;
  virtual CostmapView Costmap() const = 0;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_LOCAL_CONTROLLER_H_

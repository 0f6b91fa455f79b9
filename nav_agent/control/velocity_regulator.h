// What regulators of the robot's velocity are made of.
#ifndef NAV_AGENT_CONTROL_VELOCITY_REGULATOR_H_
#define NAV_AGENT_CONTROL_VELOCITY_REGULATOR_H_

#include <limits>
#include <optional>
#include <span>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/track_point.h"
#include "nav_agent/control/velocity_limits.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// The end of the path that is driven.
struct GoalAhead {
  geometry::Rigid2 map_from_goal;
  // Along the path still to go (m).
  double left_m = 0;
};

// What regulators may look at in one step: the same for all of them.
struct RegulatorInput {
  const ControlPose& pose;
  const LocalCostmap& costmap;
  const CollisionGuard& guard;
  // What the guard keeps away from.
  std::span<const GuardPoint> points;
  // What limits of acceleration start from.
  LastCommands::Start start;
  // The pose is finite, and each laser has shown something lately.
  bool sees = false;
  // What speed zones allow where the robot is (m/s).
  double max_mps = std::numeric_limits<double>::infinity();

  // ---- of a drive along a path; a recovery's command has none of this ----
  std::span<const TrackPoint> track = {};
  std::optional<GoalAhead> goal = std::nullopt;
  // It has not got on for too long, and should try other ways; or should wait.
  bool should_escape = false;
  bool should_wait = false;
  // Somebody may come up behind it, where it does not see; and so soon that it
  // must not back up.
  bool people_are_about = false;
  bool may_back_up = false;
};

// What goes from one regulator to the next.
struct RegulatedVelocity {
  core::VelocityCommand velocity;
  // The same before it waits, and before all limits: what the robot would do.
  core::VelocityCommand wanted;

  // ---- what regulators say of it to those after them ----
  // It is steered onto its goal; turns there; is there.
  bool is_near_goal = false;
  bool is_turning_at_goal = false;
  bool is_at_goal = false;
  bool escapes = false;
  bool waits = false;
  // It has to stand, braking along its arc.
  bool must_stop = false;

  // What can be done next of it along its own arc; nullopt: as `velocity`.
  std::optional<core::VelocityCommand> along_arc = std::nullopt;

  // ---- why it is not what was wanted ----
  bool is_limited = false;
  // What forbids it, and whether that moves.
  std::optional<geometry::Vec2> point_in_map = std::nullopt;
  bool point_moves = false;
};

// One reason to drive otherwise. Regulators may remember what they did
// (hysteresis); they know each other only by what is in RegulatedVelocity. Not
// thread-safe.
class VelocityRegulator {
 public:
  virtual ~VelocityRegulator() = default;
  // For logs and tests.
  virtual const char* name() const = 0;
  virtual void Regulate(const RegulatorInput& input,
                        RegulatedVelocity& regulated) = 0;
  // There is a new path.
  virtual void Reset() {}
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_VELOCITY_REGULATOR_H_

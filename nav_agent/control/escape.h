// Small moves that get a robot on when the one it wants is not allowed.
#ifndef NAV_AGENT_CONTROL_ESCAPE_H_
#define NAV_AGENT_CONTROL_ESCAPE_H_

#include <optional>
#include <span>

#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/track_follower.h"

namespace treeline::control {

// A robot that stands askew beside a wall cannot turn where it stands: it has
// to back off first. Of a few slow commands, those that the collision guard
// allows as they are, the one after which (1 or 2 s on) the robot looks most
// along its track, has most room about it, may turn to its track, and has not
// lost way. Held for a while, so that the robot does not dither. Not
// thread-safe.
class Escape {
 public:
  void Reset() { held_.reset(); }
  // nullopt: none is allowed. Without `may_back_up`, none that goes back.
  std::optional<core::VelocityCommand> Find(const ControlPose& pose,
                                            std::span<const TrackPoint> track,
                                            const core::VelocityCommand& wanted,
                                            bool may_back_up,
                                            const LocalCostmap& costmap,
                                            const CollisionGuard& guard,
                                            std::span<const GuardPoint> points);

 private:
  std::optional<core::VelocityCommand> held_;
  base::MonotonicTime held_since_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ESCAPE_H_

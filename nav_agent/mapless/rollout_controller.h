// From the way to a velocity: many commands are tried out, the best is given.
#ifndef NAV_AGENT_MAPLESS_ROLLOUT_CONTROLLER_H_
#define NAV_AGENT_MAPLESS_ROLLOUT_CONTROLLER_H_

#include <optional>

#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/mapless/body_shape.h"
#include "nav_agent/mapless/timed_way.h"
#include "nav_agent/mapless/way_field.h"

namespace treeline::mapless {

struct RolloutLimits {
  // At most the robot's own.
  double max_forward_mps = 0;
  double max_yaw_rate_radps = 0;
};

// Where a robot is and how it moves.
struct RobotMotion {
  geometry::Rigid2 map_from_base;
  double forward_mps = 0;
  double yaw_rate_radps = 0;
};

// What is around the robot, at the time from which rollouts begin.
struct Surroundings {
  ClearanceWindow clearance;
  std::vector<Mover> movers = {};
};

// Each rollout is a speed and a curve, and another curve after kFirstPart_s,
// as the robot's accelerations let it follow them; at its end it brakes. One is
// possible if the body touches nothing of the map on all of that, so that the
// robot can always stop. The best is the one from whose end the least is to go
// (WayField); speed is limited by the room beside the body. Among what moves,
// the threat of each moment counts, and what is to go from its end at that time
// (TimedWay); it may drive backwards then. The dynamic window
// approach (Fox, Burgard, Thrun 1997) with two curves and a distance to the
// goal that knows the way. Deterministic; not thread-safe.
class RolloutController {
 public:
  RolloutController(const core::RobotModel& robot, const BodyShape& body,
                    const RolloutLimits& limits);

  // nullopt: none is possible that gets on; the robot should stand.
  std::optional<core::VelocityCommand> Best(const RobotMotion& motion,
                                            const Surroundings& around,
                                            const WayField& way,
                                            const TimedWay& timed);
  // The one of backing off and turning on the spot that ends with the most
  // room; standing, if none is possible.
  core::VelocityCommand BackOff(const RobotMotion& motion,
                                const Surroundings& around);
  // A turn on the spot by about this angle, as far as it is possible.
  core::VelocityCommand Turn(const RobotMotion& motion,
                             const Surroundings& around, double by_rad) const;
  // The largest part of a command of somebody else that is possible.
  core::VelocityCommand Allow(const RobotMotion& motion,
                              const Surroundings& around,
                              const core::VelocityCommand& wanted) const;
  // Another goal: the last command means nothing.
  void Restart() { last_.reset(); }

 private:
  struct Choice {
    core::VelocityCommand first;
    double later_yaw_rate_radps = 0;
  };
  struct Outcome {
    geometry::Rigid2 end;
    double min_room_m = 0;
    // Of speed beyond what room allows, summed over time (m).
    double haste_m = 0;
    // Of what moves, over all of it (m).
    double threat_m = 0;
  };

  std::optional<Outcome> TryOut(const RobotMotion& motion, const Choice& choice,
                                const Surroundings& around) const;
  void Advance(RobotMotion& motion, double forward_mps, double yaw_rate_radps,
               double dt_s) const;
  double ThreatAt_mps(const geometry::Rigid2& map_from_base,
                      const std::vector<Mover>& movers, double time_s) const;
  bool IsAllowed(const RobotMotion& motion, const Choice& choice,
                 const Surroundings& around) const;
  double CostOf(const Outcome& outcome, const Choice& choice,
                const WayField& way, const TimedWay& timed) const;

  core::RobotModel robot_;
  BodyShape body_;
  RolloutLimits limits_;
  std::optional<Choice> last_;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_ROLLOUT_CONTROLLER_H_

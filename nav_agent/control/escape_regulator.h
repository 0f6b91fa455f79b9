// Small moves that get a robot on when the one it wants is not allowed.
#ifndef NAV_AGENT_CONTROL_ESCAPE_REGULATOR_H_
#define NAV_AGENT_CONTROL_ESCAPE_REGULATOR_H_

#include <optional>

#include "nav_agent/control/velocity_regulator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// A robot that stands askew beside a wall cannot turn where it stands: it has
// to back off first. Of a few slow commands, those that the collision guard
// allows as they are and as they begin, the one after which (kEscapeAhead_s or
// twice that on) the robot looks most along its track, has most room about it,
// may turn to its track, and has not lost way; none that goes back unless it
// may back up. Held for a while, so that the robot does not dither. Works when
// it should escape and is not at its goal; says that it escapes, even if it
// finds nothing and leaves the velocity as it was.
class EscapeRegulator final : public VelocityRegulator {
 public:
  explicit EscapeRegulator(const core::RobotModel& robot) : robot_(robot) {}

  const char* name() const override { return "escape"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override;
  void Reset() override { held_.reset(); }

 private:
  // nullopt: none is allowed, or the wanted one is.
  std::optional<core::VelocityCommand> Find(
      const RegulatorInput& input, const core::VelocityCommand& wanted);
  std::optional<core::VelocityCommand> Best(const RegulatorInput& input) const;
  // The guard allows it, and the first that the base does of it.
  bool MayBegin(const RegulatorInput& input,
                const core::VelocityCommand& command) const;

  core::RobotModel robot_;
  std::optional<core::VelocityCommand> held_;
  base::MonotonicTime held_since_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ESCAPE_REGULATOR_H_

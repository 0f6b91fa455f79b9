// The last decimetres: onto the goal, then round to its heading.
#ifndef NAV_AGENT_CONTROL_APPROACH_REGULATOR_H_
#define NAV_AGENT_CONTROL_APPROACH_REGULATOR_H_

#include <cstdint>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/setting_parameters.h"
#include "nav_agent/control/velocity_regulator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

struct ApproachOptions {
  double tolerance_m = kGoalTolerance_m;
  double tolerance_rad = kGoalToleranceAngle_rad;
};

// From kGoalNear_m on, along the path and in a line, it steers the robot: ahead
// or back onto the goal, then round on the spot. Says is_near_goal, and at the
// goal, within both tolerances with room to spare, is_at_goal; the robot may
// still be moving then. Farther away it changes nothing.
class ApproachRegulator final : public VelocityRegulator {
 public:
  ApproachRegulator(const core::RobotModel& robot,
                    const ApproachOptions& options)
      : robot_(robot), options_(options) {}

  const char* name() const override { return "approach"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override;
  void Reset() override { phase_ = Phase::kFar; }

 private:
  enum class Phase : uint8_t { kFar, kMove, kTurn, kDone };

  bool IsNear(const geometry::Rigid2& map_from_base, const GoalAhead& goal);
  core::VelocityCommand Command(const geometry::Rigid2& map_from_base,
                                const geometry::Rigid2& map_from_goal);
  core::VelocityCommand MoveTo(geometry::Vec2 goal_in_base);

  core::RobotModel robot_;
  ApproachOptions options_;
  Phase phase_ = Phase::kFar;
  bool aligns_ = false;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_APPROACH_REGULATOR_H_

// Along the track.
#ifndef NAV_AGENT_CONTROL_PURSUIT_REGULATOR_H_
#define NAV_AGENT_CONTROL_PURSUIT_REGULATOR_H_

#include "nav_agent/control/speed_profile.h"
#include "nav_agent/control/velocity_regulator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// Pure pursuit (Coulter, "Implementation of the Pure Pursuit Path Tracking
// Algorithm", CMU 1992) of a point ahead on the track, at the speed that
// SpeedProfile allows here; the further off its heading that is, the slower.
// Off by more than kTurnFrom_rad it turns on the spot, until kTurnUntil_rad. To
// stand at the track's end, which is the end of what it sees. A robot near its
// goal is steered already.
class PursuitRegulator final : public VelocityRegulator {
 public:
  PursuitRegulator(const core::RobotModel& robot,
                   const SpeedProfileOptions& options)
      : robot_(robot), options_(options) {}

  const char* name() const override { return "pursuit"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override;
  void Reset() override { is_turning_ = false; }

 private:
  core::VelocityCommand Command(const ControlPose& pose,
                                std::span<const TrackPoint> track);

  core::RobotModel robot_;
  SpeedProfileOptions options_;
  bool is_turning_ = false;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_PURSUIT_REGULATOR_H_

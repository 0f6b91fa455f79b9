#include "nav_agent/control/velocity_regulators.h"

#include <utility>

#include "nav_agent/control/acceleration_regulator.h"
#include "nav_agent/control/collision_regulator.h"
#include "nav_agent/control/escape_regulator.h"
#include "nav_agent/control/pursuit_regulator.h"
#include "nav_agent/control/rounded_turn_regulator.h"
#include "nav_agent/control/sensor_regulator.h"
#include "nav_agent/control/speed_zone_regulator.h"
#include "nav_agent/control/wait_regulator.h"

namespace treeline::control {

VelocityRegulators::VelocityRegulators(
    const core::RobotModel& robot, const VelocityRegulatorsOptions& options) {
  const VelocityRegulatorSwitches& is_on = options.switches;
  const auto add = [](Chain& chain, bool is_at_work,
                      std::unique_ptr<VelocityRegulator> regulator) {
    if (is_at_work) chain.push_back(std::move(regulator));
  };
  // The order: see the class.
  add(steering_, is_on.approach,
      std::make_unique<ApproachRegulator>(robot, options.approach));
  add(steering_, is_on.pursuit,
      std::make_unique<PursuitRegulator>(
          robot, SpeedProfileOptions{.max_forward_mps = options.max_forward_mps,
                                     .switches = is_on.speed}));
  add(steering_, is_on.escape, std::make_unique<EscapeRegulator>(robot));
  add(steering_, is_on.rounded_turn,
      std::make_unique<RoundedTurnRegulator>(robot));
  add(stopping_, is_on.wait, std::make_unique<WaitRegulator>());
  add(stopping_, is_on.speed_zone, std::make_unique<SpeedZoneRegulator>());
  add(stopping_, is_on.sensors, std::make_unique<SensorRegulator>());
  add(stopping_, is_on.acceleration,
      std::make_unique<AccelerationRegulator>(robot));
  add(stopping_, is_on.collision, std::make_unique<CollisionRegulator>(robot));
}

RegulatedVelocity VelocityRegulators::Drive(const RegulatorInput& input) {
  RegulatedVelocity regulated;
  for (const auto& regulator : steering_) regulator->Regulate(input, regulated);
  regulated.wanted = regulated.velocity;
  for (const auto& regulator : stopping_) regulator->Regulate(input, regulated);
  return regulated;
}

RegulatedVelocity VelocityRegulators::Allow(
    const RegulatorInput& input, const core::VelocityCommand& wanted) {
  RegulatedVelocity regulated = {.velocity = wanted, .wanted = wanted};
  for (const auto& regulator : stopping_) regulator->Regulate(input, regulated);
  return regulated;
}

void VelocityRegulators::Reset() {
  for (Chain* chain : {&steering_, &stopping_}) {
    for (const auto& regulator : *chain) regulator->Reset();
  }
}

std::vector<std::string> VelocityRegulators::Names() const {
  std::vector<std::string> names;
  for (const Chain* chain : {&steering_, &stopping_}) {
    for (const auto& regulator : *chain) names.emplace_back(regulator->name());
  }
  return names;
}

}  // namespace treeline::control

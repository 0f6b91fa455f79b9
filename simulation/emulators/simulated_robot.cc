#include "simulation/emulators/simulated_robot.h"

#include <chrono>
#include <utility>

#include "common/base/status_macros.h"

namespace treeline::emulators {

absl::StatusOr<std::unique_ptr<SimulatedRobot>> SimulatedRobot::Create(
    simulator::Simulator& simulator, base::MonotonicTime start) {
  const simulator::SimulatorOptions& options = simulator.options();
  TL_ASSIGN_OR_RETURN(
      sensors::LaserScanner scanner,
      sensors::LaserScanner::Create(simulator.world(), options.sensors.laser,
                                    options.seed));
  return std::unique_ptr<SimulatedRobot>(
      new SimulatedRobot(simulator, std::move(scanner), start));
}

void SimulatedRobot::AdvanceTo(simulator::SimTime time) {
  const simulator::SimTime now = simulator_.now();
  if (time > now) simulator_.Step(time - now);
}

core::LaserScan SimulatedRobot::ScanFrom(core::LaserMount mount,
                                         base::MonotonicTime start,
                                         const core::RangeSensorInfo& info) {
  const simulator::SimTime first =
      std::chrono::duration_cast<simulator::SimTime>(start - start_);
  const simulator::SimTime last =
      first + simulator::FromSeconds((info.beams - 1) * info.beam_interval_s);
  const geometry::Rigid3& base_from_laser =
      simulator_.options().robot.BaseFrom(mount);
  const absl::MutexLock lock(&mutex_);
  AdvanceTo(last);
  sensors::LaserReturns returns =
      scanner_.Scan(simulator_.caster().At(simulator_.bodies()),
                    simulator_.WorldFromBaseAt(first) * base_from_laser,
                    simulator_.WorldFromBaseAt(last) * base_from_laser,
                    static_cast<uint64_t>(scans_++));
  return {.stamp = start,
          .ranges_m = std::move(returns.ranges_m),
          .intensities = std::move(returns.intensities)};
}

BasePlantState SimulatedRobot::Step(const core::VelocityCommand& wanted,
                                    double interval_s) {
  const absl::MutexLock lock(&mutex_);
  // A base without commands is asked to stand; it is lost in no simulation.
  simulator_.base().SetVelocity(wanted).IgnoreError();
  base_time_ += simulator::FromSeconds(interval_s);
  AdvanceTo(base_time_);
  for (const core::BaseReading& reading :
       simulator_.odometry().TakeReadings()) {
    const double half_turn_mps =
        0.5 * simulator_.options().robot.wheel_track_m * reading.yaw_rate_radps;
    state_ = {.left_wheel_m = reading.left_wheel_m,
              .right_wheel_m = reading.right_wheel_m,
              .left_wheel_mps = reading.forward_mps - half_turn_mps,
              .right_wheel_mps = reading.forward_mps + half_turn_mps,
              .yaw_rate_radps = reading.yaw_rate_radps,
              .pitch_rad = reading.pitch_rad,
              .pitch_rate_radps = reading.pitch_rate_radps,
              .roll_rad = reading.roll_rad,
              .roll_rate_radps = reading.roll_rate_radps};
  }
  return state_;
}

}  // namespace treeline::emulators

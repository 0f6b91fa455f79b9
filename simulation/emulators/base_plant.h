// What an emulated base drives on.
#ifndef SIMULATION_EMULATORS_BASE_PLANT_H_
#define SIMULATION_EMULATORS_BASE_PLANT_H_

#include "nav_agent/core/sensor_data.h"

namespace treeline::emulators {

// What the base's own sensors see. Wheels count what they have rolled since the
// beginning (m); angles as in BaseReading.
struct BasePlantState {
  double left_wheel_m = 0;
  double right_wheel_m = 0;
  double left_wheel_mps = 0;
  double right_wheel_mps = 0;
  double yaw_rate_radps = 0;
  double pitch_rad = 0;
  double pitch_rate_radps = 0;
  double roll_rad = 0;
  double roll_rate_radps = 0;
};

// The body of the robot and the world below it. The emulator asks for speeds
// that already obey the base's acceleration limits; the plant says what became
// of them.
class BasePlant {
 public:
  virtual ~BasePlant() = default;
  virtual BasePlantState Step(const core::VelocityCommand& wanted,
                              double interval_s) = 0;
};

// A level floor without slip: the wheels do as they are told.
class FlatFloorPlant final : public BasePlant {
 public:
  explicit FlatFloorPlant(double wheel_track_m)
      : wheel_track_m_(wheel_track_m) {}

  BasePlantState Step(const core::VelocityCommand& wanted,
                      double interval_s) override {
    const double half_turn_mps = 0.5 * wheel_track_m_ * wanted.yaw_rate_radps;
    state_.left_wheel_mps = wanted.forward_mps - half_turn_mps;
    state_.right_wheel_mps = wanted.forward_mps + half_turn_mps;
    state_.left_wheel_m += state_.left_wheel_mps * interval_s;
    state_.right_wheel_m += state_.right_wheel_mps * interval_s;
    state_.yaw_rate_radps = wanted.yaw_rate_radps;
    return state_;
  }

 private:
  const double wheel_track_m_;
  BasePlantState state_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_BASE_PLANT_H_

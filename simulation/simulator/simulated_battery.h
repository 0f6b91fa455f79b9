// A battery that a simulated robot drains.
#ifndef SIMULATION_SIMULATOR_SIMULATED_BATTERY_H_
#define SIMULATION_SIMULATOR_SIMULATED_BATTERY_H_

#include <algorithm>

namespace treeline::simulator {

struct SimulatedBatteryOptions {
  // Of a full and of an empty one; in between in a straight line (V).
  double full_v = 78;
  double empty_v = 66;
  // From full to empty (s).
  double standing_s = 8 * 3600;
  double driving_s = 3 * 3600;
};

// Full at first. An empty one drives on: nothing is said of robots that stand
// still for it. Not thread-safe.
class SimulatedBattery {
 public:
  explicit SimulatedBattery(const SimulatedBatteryOptions& options = {})
      : options_(options) {}

  void Drain(double seconds, bool is_driving) {
    charge_ =
        std::max(0.0, charge_ - seconds / (is_driving ? options_.driving_s
                                                      : options_.standing_s));
  }
  // In [0, 1].
  double charge() const { return charge_; }
  double voltage_v() const {
    return options_.empty_v + charge_ * (options_.full_v - options_.empty_v);
  }

 private:
  SimulatedBatteryOptions options_;
  double charge_ = 1;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SIMULATED_BATTERY_H_

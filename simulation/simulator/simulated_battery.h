// A battery that a simulated robot drains, and chargers that fill it.
#ifndef SIMULATION_SIMULATOR_SIMULATED_BATTERY_H_
#define SIMULATION_SIMULATOR_SIMULATED_BATTERY_H_

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/geometry/planar_pose.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"

namespace treeline::simulator {

struct SimulatedBatteryOptions {
  // Of a full and of an empty one; in between in a straight line (V).
  double full_v = 78;
  double empty_v = 66;
  // From full to empty (s).
  double standing_s = 8 * 3600;
  double driving_s = 3 * 3600;
  // From empty to full (s).
  double charging_s = 1.5 * 3600;
  // At first, in [0, 1].
  double charge = 1;
};

// An empty one drives on: nothing is said of robots that stand still for it.
// Not thread-safe.
class SimulatedBattery {
 public:
  explicit SimulatedBattery(const SimulatedBatteryOptions& options = {})
      : options_(options), charge_(options.charge) {}

  void Drain(double seconds, bool is_driving) {
    charge_ =
        std::max(0.0, charge_ - seconds / (is_driving ? options_.driving_s
                                                      : options_.standing_s));
  }
  void Charge(double seconds) {
    charge_ = std::min(1.0, charge_ + seconds / options_.charging_s);
  }
  void SetCharging(bool is_charging) { is_charging_ = is_charging; }
  bool is_charging() const { return is_charging_; }
  // In [0, 1].
  double charge() const { return charge_; }
  double voltage_v() const {
    return options_.empty_v + charge_ * (options_.full_v - options_.empty_v);
  }

 private:
  SimulatedBatteryOptions options_;
  double charge_;
  bool is_charging_ = false;
};

// A charger whose contacts meet those of a robot that stands there.
struct Charger {
  geometry::Rigid2 map_from_docked;
  // Of its ground (m).
  double height_m = 0;
};

// They charge on contact: as exactly a robot must stand. Not thread-safe.
class Chargers {
 public:
  explicit Chargers(std::vector<Charger> chargers = {})
      : chargers_(std::move(chargers)) {}

  bool Touch(const geometry::Rigid3& map_from_base) const {
    const geometry::Rigid2 robot = geometry::PlanarPose(map_from_base);
    return std::ranges::any_of(chargers_, [&](const Charger& charger) {
      const geometry::Rigid2 off = charger.map_from_docked.Inverse() * robot;
      return std::abs(off.translation.x) <= kContact_m &&
             std::abs(off.translation.y) <= kContact_m &&
             std::abs(off.yaw_rad) <= kContact_rad &&
             std::abs(map_from_base.translation.z - charger.height_m) <=
                 kSameFloor_m;
    });
  }

 private:
  // How far contacts reach (m, rad): plates of 6 cm, 5 degrees.
  static constexpr double kContact_m = 0.03;
  static constexpr double kContact_rad = 0.087;
  static constexpr double kSameFloor_m = 1;

  std::vector<Charger> chargers_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SIMULATED_BATTERY_H_

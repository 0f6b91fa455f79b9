// What can go wrong with a robot, on purpose.
#ifndef SIMULATION_SIMULATOR_FAULT_H_
#define SIMULATION_SIMULATOR_FAULT_H_

#include <chrono>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "simulation/simulator/differential_drive.h"

namespace treeline::simulator {

// Simulated time since the simulation began.
using SimTime = std::chrono::nanoseconds;

inline double Seconds(SimTime time) {
  return std::chrono::duration<double>(time).count();
}
// The nearest nanosecond.
inline SimTime FromSeconds(double time_s) {
  return SimTime(
      static_cast<int64_t>(time_s * 1e9 + (time_s < 0 ? -0.5 : 0.5)));
}

enum class FaultTarget {
  kLaser,
  kCamera,
  kOdometry,
  kBase,
  kLeftWheel,
  kRightWheel,
  kServer,
  kRearLaser
};

enum class FaultKind {
  // laser, camera, odometry: nothing comes; base: commands are refused and the
  // robot stops; server: dead.
  kSilent,
  // laser, camera, odometry: the last measurement again and again, with new
  // stamps.
  kFrozen,
  // laser: that share of the ranges is NaN; camera: no depth.
  kInvalid,
  // camera: black.
  kDark,
  // laser, camera, odometry: stamps are wrong by this many seconds.
  kStampOffset,
  // laser, camera, odometry: this many seconds later than otherwise.
  kDelay,
  // wheels: does not turn.
  kStuck,
  // wheels: that share of its way is lost.
  kSlip
};

struct Fault {
  FaultTarget target = FaultTarget::kLaser;
  FaultKind kind = FaultKind::kSilent;
  SimTime start{0};
  // SimTime::max(): until the end.
  SimTime duration = SimTime::max();
  // A share in [0, 1], or seconds; see the kinds.
  double amount = 1;

  bool IsActiveAt(SimTime time) const {
    return time >= start && time - start < duration;
  }
  // INVALID_ARGUMENT if there is no such fault of that target, or the amount
  // is out of range.
  absl::Status Validate() const;
  // "laser silent", "left_wheel slip 0.5".
  std::string Name() const;
};

absl::StatusOr<FaultTarget> ParseFaultTarget(absl::string_view name);
absl::StatusOr<FaultKind> ParseFaultKind(absl::string_view name);

// All faults of a simulation.
class FaultPlan {
 public:
  // INVALID_ARGUMENT as Fault::Validate.
  absl::Status Add(const Fault& fault);
  // Ends those of a target that are active or to come.
  void End(FaultTarget target, SimTime now);

  // The first of that kind that is active; null: none.
  const Fault* Find(FaultTarget target, FaultKind kind, SimTime time) const;
  bool Has(FaultTarget target, FaultKind kind, SimTime time) const {
    return Find(target, kind, time) != nullptr;
  }
  WheelFaults WheelsAt(SimTime time) const;

  // Faults that began (or ended) in (after, until].
  std::vector<Fault> Began(SimTime after, SimTime until) const;
  std::vector<Fault> Ended(SimTime after, SimTime until) const;

 private:
  std::vector<Fault> faults_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_FAULT_H_

// Notices a base that turns the wrong way.
#ifndef NAV_AGENT_DRIVERS_SEGWAY_TURN_WATCH_H_
#define NAV_AGENT_DRIVERS_SEGWAY_TURN_WATCH_H_

#include <optional>

#include "common/base/clock.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::segway {

// Sources disagree on which way a positive turn command turns the base, and a
// controller that is wrong about it drives in circles ever faster. So the first
// real turn is compared with what the wheels do: once a turn of one sign has
// been asked for without a break for half a second, which is longer than the
// base needs to follow, the wheels must turn the base that way too, and not the
// other. Whichever of the two comes first, by kDecisive_rad, decides for good.
class TurnWatch {
 public:
  enum class Verdict { kUndecided, kRight, kWrong };

  explicit TurnWatch(double wheel_track_m) : wheel_track_m_(wheel_track_m) {}

  // What has been asked for, each time that it is.
  void Sent(double yaw_rate_radps, base::MonotonicTime now);
  void Take(const core::BaseReading& reading, base::MonotonicTime now);
  Verdict verdict() const { return verdict_; }

 private:
  const double wheel_track_m_;
  Verdict verdict_ = Verdict::kUndecided;
  // Of the turn that is being asked for: 1, -1, or 0 for none that counts.
  int sign_ = 0;
  base::MonotonicTime since_;
  // Right less left wheel when the turn had lasted long enough (m).
  std::optional<double> difference_m_;
};

}  // namespace treeline::segway

#endif  // NAV_AGENT_DRIVERS_SEGWAY_TURN_WATCH_H_

// Whether a robot that does not get on waits, or is blocked.
#ifndef NAV_AGENT_CONTROL_STUCK_DETECTOR_H_
#define NAV_AGENT_CONTROL_STUCK_DETECTOR_H_

#include <optional>

#include "common/base/clock.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/local_controller.h"
#include "nav_agent/control/manoeuvre_parameters.h"

namespace treeline::control {

struct StuckDetectorOptions {
  // A break must last before it counts, and be gone before it does not (s).
  double break_s = kBreak_s;
  double mended_s = kBreak_s;
  // What has been there for less may go away by itself, and is waited for at
  // most so long (s).
  double young_s = kRecently_s;
  double patience_s = kPatience_s;
  // Driving that gets nowhere: this far in this time (m, rad, s).
  double progress_m = kCell_m;
  double progress_rad = kProgressAngle_rad;
  double stuck_s = kStuck_s;
  // Without anything seen in its way, it is held by something unseen after this
  // time (s).
  double held_s = kRecently_s;
  // So long other ways are tried to get on (s).
  double escape_s = kPatience_s;
};

struct StuckDetectorInput {
  base::MonotonicTime stamp;
  geometry::Rigid2 at;
  bool wants_to_move = false;
  // The band is broken just ahead; the collision stop changes commands.
  bool is_broken = false;
  bool is_guarded = false;
  std::optional<geometry::Vec2> obstacle_in_map = std::nullopt;
  double obstacle_radius_m = 0;
  double obstacle_age_s = 1e6;
};

// Not thread-safe.
class StuckDetector {
 public:
  explicit StuckDetector(const StuckDetectorOptions& options = {})
      : options_(options) {}

  void Reset();
  // kDriving, kWaiting or kBlocked.
  ControlState Judge(const StuckDetectorInput& input);
  // The robot should try to get on another way than the one it wants.
  bool WantsEscape() const { return wants_escape_; }
  // It waits, or is blocked before a broken band: it should stand.
  bool Holds() const { return holds_; }

 private:
  bool IsStuck(const StuckDetectorInput& input);
  ControlState Decide(const StuckDetectorInput& input);

  StuckDetectorOptions options_;
  std::optional<base::MonotonicTime> broken_since_;
  std::optional<base::MonotonicTime> whole_since_;
  std::optional<base::MonotonicTime> waiting_since_;
  // Where it got on last.
  std::optional<base::MonotonicTime> moved_at_;
  geometry::Rigid2 moved_to_;
  std::optional<base::MonotonicTime> escaping_since_;
  bool wants_escape_ = false;
  bool holds_ = false;
  bool is_blocked_ = false;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_STUCK_DETECTOR_H_

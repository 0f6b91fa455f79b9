// Whether a robot that drives gets on.
#ifndef NAV_AGENT_BEHAVIOR_PROGRESS_CHECKER_H_
#define NAV_AGENT_BEHAVIOR_PROGRESS_CHECKER_H_

#include <cstddef>
#include <limits>
#include <optional>

#include "nav_agent/behavior/navigator.h"

namespace treeline::behavior {

// Two questions. Has it got on lately: less to go, or turned, once? And has it
// come nearer to the goal than ever, which gives a goal its recoveries back:
// that can happen so often only as the way has metres, so no goal takes for
// ever. Not thread-safe.
class ProgressChecker {
 public:
  explicit ProgressChecker(const NavigatorLimits& limits) : limits_(limits) {}

  // A new goal.
  void Reset() { *this = ProgressChecker(limits_); }
  // The watch begins anew: a new path, a pause, a recovery.
  void Restart() { since_.reset(); }

  // While it drives. leg: counts poses that have been reached. False: it has
  // not got on for progress_s.
  bool Observe(base::MonotonicTime now, size_t leg, double to_go_m,
               double yaw_rad);
  // Whether it has got on by recovery_reset_m further than ever; once for each.
  bool TakeRefill();

 private:
  NavigatorLimits limits_;
  std::optional<base::MonotonicTime> since_;
  // When the watch last saw progress.
  double to_go_m_ = 0;
  double yaw_rad_ = 0;
  // Turns count once between two of way, or turning to and fro were progress.
  bool has_turned_ = false;
  // Of the goal.
  size_t leg_ = 0;
  double min_to_go_m_ = std::numeric_limits<double>::infinity();
  double refilled_at_m_ = std::numeric_limits<double>::infinity();
  bool refill_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PROGRESS_CHECKER_H_

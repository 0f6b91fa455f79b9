// A goal that something stands on, or that leaves no room to turn: how often it
// is tried, and how long is waited between.
#ifndef NAV_AGENT_BEHAVIOR_OCCUPIED_GOAL_H_
#define NAV_AGENT_BEHAVIOR_OCCUPIED_GOAL_H_

#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {

// What stands there comes and goes in what the sensors say, as the robot turns
// and its scans reach elsewhere: without waits it would be driven to and given
// up twice a second. The first wait is kFirstWait_s, each next one twice as
// long, all together at most kGoalWait_s. Not thread-safe.
class OccupiedGoal {
 public:
  // It kept the robot from its goal, again. False: there is no time for
  // another wait.
  bool Meet(base::MonotonicTime now) {
    if (met_at_.has_value()) wait_s_ *= 2;
    met_at_ = now;
    if (!since_.has_value()) since_ = now;
    waits_s_ += wait_s_;
    return waits_s_ <= kGoalWait_s;
  }
  // Whether a goal that seems to be free is to be tried now.
  bool MayTry(base::MonotonicTime now) const {
    return !met_at_.has_value() ||
           (waits_s_ <= kGoalWait_s &&
            base::SecondsBetween(*met_at_, now) >= wait_s_);
  }
  // There is no way to it, nor to a place beside. Whether that has been so for
  // long enough: since it was met first, kBlockageMemory_s, after which what is
  // not seen any more is forgotten.
  bool HasWaited(base::MonotonicTime now) {
    if (!since_.has_value()) since_ = now;
    return base::SecondsBetween(*since_, now) > kBlockageMemory_s;
  }
  // True once: people are to be told.
  bool TellOnce() { return !std::exchange(has_told_, true); }
  // Another goal, or the robot has come notably nearer.
  void Reset() { *this = OccupiedGoal(); }

 private:
  // Met first, and last.
  std::optional<base::MonotonicTime> since_;
  std::optional<base::MonotonicTime> met_at_;
  double wait_s_ = kFirstWait_s;
  double waits_s_ = 0;
  bool has_told_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_OCCUPIED_GOAL_H_

// A lost robot that what the map has about a wrong place would hold for ever.
#ifndef NAV_AGENT_BEHAVIOR_HELD_SEARCH_H_
#define NAV_AGENT_BEHAVIOR_HELD_SEARCH_H_

#include <optional>

#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::behavior {

// Whether nothing that the search wants is allowed, to either side: then places
// that are only supposed do not count until it has had time to turn around.
// What was seen counts all the time. Not thread-safe.
class HeldSearch {
 public:
  void Step(const core::VelocityCommand& wanted,
            const core::VelocityCommand& allowed, base::MonotonicTime now) {
    const bool moves = allowed.forward_mps != 0 || allowed.yaw_rate_radps != 0;
    const bool wants = wanted.forward_mps != 0 || wanted.yaw_rate_radps != 0;
    if (moves || !wants) {
      since_.reset();
      return;
    }
    if (!since_.has_value()) since_ = now;
    if (base::SecondsBetween(*since_, now) < kSearchHeld_s) return;
    freed_ = now;
    since_.reset();
  }
  bool MaySuppose(base::MonotonicTime now) const {
    return !freed_.has_value() ||
           base::SecondsBetween(*freed_, now) > kFullTurn_s;
  }

 private:
  std::optional<base::MonotonicTime> since_;
  std::optional<base::MonotonicTime> freed_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_HELD_SEARCH_H_

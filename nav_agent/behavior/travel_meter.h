// How far a robot has driven.
#ifndef NAV_AGENT_BEHAVIOR_TRAVEL_METER_H_
#define NAV_AGENT_BEHAVIOR_TRAVEL_METER_H_

#include <optional>
#include <utility>

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/core/level_pose.h"

namespace treeline::behavior {

class TravelMeter {
 public:
  // From the position of the step before to this one, in the map (m). 0: there
  // was none, or the estimate jumped.
  double Step_m(geometry::Vec2 position) {
    const std::optional<geometry::Vec2> last =
        std::exchange(last_position_, position);
    if (!last.has_value()) return 0;
    const double way_m = geometry::Norm(position - *last);
    return way_m < kMaxStepMove_m ? way_m : 0;
  }
  // The next position begins anew.
  void Restart() { last_position_.reset(); }

 private:
  std::optional<geometry::Vec2> last_position_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_TRAVEL_METER_H_

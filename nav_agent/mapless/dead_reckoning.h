// Where a robot without a map is: where its wheels and its gyroscope took it
// from where it began.
#ifndef NAV_AGENT_MAPLESS_DEAD_RECKONING_H_
#define NAV_AGENT_MAPLESS_DEAD_RECKONING_H_

#include <deque>
#include <optional>

#include "common/base/clock.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::mapless {

struct ReckonedPose {
  base::MonotonicTime stamp;
  geometry::Rigid2 map_from_base;
  double forward_mps = 0;
  double yaw_rate_radps = 0;
};

// On level ground; distances are the wheels', headings the gyroscope's, which
// no wheel that slips turns. Begins at the map's origin. Not thread-safe.
class DeadReckoning {
 public:
  // In the order of their stamps. A jump of the wheels' counters (the base was
  // switched on again) moves nothing.
  void Add(const core::BaseReading& reading);
  // The robot is there now.
  void SetPose(const geometry::Rigid2& map_from_base);

  // The newest; nullopt: nothing has been heard.
  std::optional<ReckonedPose> Newest() const;
  // Between readings it moved evenly; for up to 0.1 s after the newest it goes
  // on as it did. nullopt: later, or longer ago than is remembered (0.5 s).
  std::optional<geometry::Rigid2> At(base::MonotonicTime stamp) const;

 private:
  struct Entry {
    base::MonotonicTime stamp;
    geometry::Rigid2 odom_from_base;
  };

  geometry::Rigid2 map_from_odom_;
  std::optional<core::BaseReading> last_;
  std::deque<Entry> entries_;
};

// The pose after moving evenly for duration_s.
geometry::Rigid2 MovedOn(const geometry::Rigid2& from, double forward_mps,
                         double yaw_rate_radps, double duration_s);

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_DEAD_RECKONING_H_

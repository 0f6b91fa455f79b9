// Where the wheels were a moment ago, as nav_msgs/Odometry tells it.
#ifndef NAV_AGENT_BRIDGE_PLACE_FINDER_ODOMETRY_TRAIL_H_
#define NAV_AGENT_BRIDGE_PLACE_FINDER_ODOMETRY_TRAIL_H_

#include <deque>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "common/ros2/messages/nav_messages.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::place_finder {

// The last ten seconds. Not thread-safe.
class OdometryTrail {
 public:
  // INVALID_ARGUMENT for poses that are none. What is older than the newest by
  // less than a second is left out; by more, the clock has begun anew, and the
  // trail does, too.
  absl::Status Add(const messages::Odometry& odometry);

  bool empty() const { return moments_.empty(); }
  // There must be one.
  const localization::TrackedMotion& newest() const { return moments_.back(); }
  // Between two messages; the newest for what is newer by 0.1 s at most.
  std::optional<localization::TrackedMotion> At(
      base::MonotonicTime stamp) const;
  // header.frame_id of the newest: "odom".
  const std::string& frame() const { return frame_; }
  // How often the clock has begun anew: ways from before lead nowhere.
  int restarts() const { return restarts_; }

 private:
  std::deque<localization::TrackedMotion> moments_;
  std::string frame_;
  int restarts_ = 0;
};

}  // namespace treeline::place_finder

#endif  // NAV_AGENT_BRIDGE_PLACE_FINDER_ODOMETRY_TRAIL_H_

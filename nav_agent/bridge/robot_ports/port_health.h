// What a port tells of itself, and what waits in it.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_PORT_HEALTH_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_PORT_HEALTH_H_

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"

namespace treeline::robot_ports {

// A topic that says nothing for so long of real time is lost, as people are
// told; what the robot does about silence, the navigator's time-outs say.
inline constexpr double kLostAfter_s = 1;

// Counts what comes on a topic. Not thread-safe.
class PortHealth {
 public:
  explicit PortHealth(std::string topic) : topic_(std::move(topic)) {}

  void NoteGood(base::MonotonicTime real_now) {
    if (IsLost(real_now)) ++health_.losses;
    last_ = real_now;
    ++health_.received;
  }
  // Returns what it is told, with the topic in front.
  absl::Status NoteBroken(const absl::Status& why) {
    ++health_.corrupt;
    last_fault_ = why;
    return why;
  }
  void NoteDropped() { ++health_.dropped; }

  core::DeviceHealth At(base::MonotonicTime real_now) const {
    core::DeviceHealth health = health_;
    if (!last_.has_value()) {
      health.cause = last_fault_.ok() ? absl::UnavailableError(absl::StrCat(
                                            "nothing has come on ", topic_))
                                      : last_fault_;
      return health;
    }
    health.state = core::DeviceState::kRunning;
    if (!IsLost(real_now)) return health;
    health.state = core::DeviceState::kLost;
    ++health.losses;
    health.cause = absl::UnavailableError(absl::StrCat(
        "nothing usable on ", topic_, " for more than ", kLostAfter_s, " s"));
    return health;
  }
  const std::string& topic() const { return topic_; }

 private:
  bool IsLost(base::MonotonicTime real_now) const {
    return last_.has_value() &&
           base::SecondsBetween(*last_, real_now) > kLostAfter_s;
  }

  std::string topic_;
  core::DeviceHealth health_;
  std::optional<base::MonotonicTime> last_;
  absl::Status last_fault_;
};

// As core/devices.h wants measurements to wait. Not thread-safe.
template <typename T>
class Waiting {
 public:
  void Add(T measurement, PortHealth& health) {
    waiting_.push_back(std::move(measurement));
    if (waiting_.size() <= size_t{core::kMaxWaiting}) return;
    waiting_.pop_front();
    health.NoteDropped();
  }
  std::vector<T> Take() {
    std::vector<T> taken(std::make_move_iterator(waiting_.begin()),
                         std::make_move_iterator(waiting_.end()));
    waiting_.clear();
    return taken;
  }

 private:
  std::deque<T> waiting_;
};

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_PORT_HEALTH_H_

// What the supervisor says of itself, in the order in which it happened.
#ifndef NAV_AGENT_BEHAVIOR_EVENT_LOG_H_
#define NAV_AGENT_BEHAVIOR_EVENT_LOG_H_

#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {

class EventLog {
 public:
  // Events from now on carry this stamp.
  void SetTime(base::MonotonicTime now) { now_ = now; }
  void Add(std::string kind, std::string text) {
    waiting_.push_back({.stamp = now_,
                        .number = ++number_,
                        .kind = std::move(kind),
                        .text = std::move(text)});
    // Nobody took them for long: the oldest go, and their numbers with them.
    if (waiting_.size() > kMaxWaitingEvents) waiting_.pop_front();
  }
  std::vector<NavigatorEvent> Take() {
    std::vector<NavigatorEvent> taken(waiting_.begin(), waiting_.end());
    waiting_.clear();
    return taken;
  }

 private:
  base::MonotonicTime now_;
  uint64_t number_ = 0;
  std::deque<NavigatorEvent> waiting_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_EVENT_LOG_H_

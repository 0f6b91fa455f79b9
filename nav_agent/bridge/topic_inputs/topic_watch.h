// Says aloud who is missing on a network, and who is there twice.
#ifndef NAV_AGENT_BRIDGE_TOPIC_INPUTS_TOPIC_WATCH_H_
#define NAV_AGENT_BRIDGE_TOPIC_INPUTS_TOPIC_WATCH_H_

#include <map>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "nav_agent/bridge/topic_inputs/topic_inputs.h"

namespace treeline::topic_inputs {

// Not thread-safe.
class TopicWatch {
 public:
  // topics: as they were called in Subscribe; each has one publisher.
  // tells_nobody: that it has none is worth a line, too.
  TopicWatch(std::vector<std::string> topics, bool tells_nobody)
      : topics_(std::move(topics)), tells_nobody_(tells_nobody) {}

  // To be called often. What is worth a line of a log now: what holds for a
  // moment, and was not said the last time.
  std::vector<std::string> Look(const TopicInputs& inputs,
                                base::MonotonicTime now);

 private:
  std::string Complaint(const TopicInputs& inputs,
                        const std::string& topic) const;

  std::vector<std::string> topics_;
  bool tells_nobody_;
  std::map<std::string, std::string> said_;
  base::MonotonicTime next_{};
};

}  // namespace treeline::topic_inputs

#endif  // NAV_AGENT_BRIDGE_TOPIC_INPUTS_TOPIC_WATCH_H_

#include "nav_agent/bridge/topic_inputs/topic_watch.h"

#include <chrono>

#include "absl/strings/str_cat.h"

namespace treeline::topic_inputs {
namespace {

// Whoever is there is found within a second or so.
constexpr auto kInterval = std::chrono::seconds(2);

}  // namespace

std::string TopicWatch::Complaint(const TopicInputs& inputs,
                                  const std::string& topic) const {
  const int publishers = inputs.publishers(topic);
  if (publishers > 1) {
    return absl::StrCat(
        publishers, " programs publish ", topic,
        ": two robots, or a robot and a recording, need a domain or a "
        "namespace each");
  }
  return publishers == 0 && tells_nobody_ ? inputs.WhyNobody(topic) : "";
}

std::vector<std::string> TopicWatch::Look(const TopicInputs& inputs,
                                          base::MonotonicTime now) {
  std::vector<std::string> lines;
  if (next_ == base::MonotonicTime{}) next_ = now + kInterval;
  if (now < next_) return lines;
  next_ = now + kInterval;
  for (const std::string& topic : topics_) {
    std::string complaint = Complaint(inputs, topic);
    std::string& said = said_[topic];
    if (complaint != said && !complaint.empty()) lines.push_back(complaint);
    said = std::move(complaint);
  }
  return lines;
}

}  // namespace treeline::topic_inputs

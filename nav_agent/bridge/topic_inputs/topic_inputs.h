// Topics that somebody listens to: decoded, handed over, counted.
#ifndef NAV_AGENT_BRIDGE_TOPIC_INPUTS_TOPIC_INPUTS_H_
#define NAV_AGENT_BRIDGE_TOPIC_INPUTS_TOPIC_INPUTS_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/ros2/messages/message_codec.h"
#include "nav_agent/bridge/dds/node.h"

namespace treeline::topic_inputs {

// Not thread-safe.
class TopicInputs {
 public:
  // The node must outlive it.
  explicit TopicInputs(dds::Node& node) : node_(node) {}

  // `deliver` gets what is decoded, and says what is wrong with it. Topics are
  // handed over in the order in which they were subscribed to.
  template <typename M>
  absl::Status Subscribe(const std::string& topic, const dds::Quality& quality,
                         std::function<absl::Status(M message)> deliver) {
    return SubscribeRaw(
        topic, M::kName, quality,
        [deliver = std::move(deliver)](std::span<const uint8_t> bytes) {
          absl::StatusOr<M> message = messages::Decode<M>(bytes);
          if (!message.ok()) return message.status();
          return deliver(*std::move(message));
        });
  }

  // What came broken, or was refused; so many of this topic so far.
  struct Fault {
    std::string topic;
    absl::Status why;
    int64_t refused = 0;
  };
  // Waits until something is there, at most so long, and hands it over. Returns
  // what is worth a line of a log: of each topic, a fault that is not the one
  // before, and of those that go on the hundredth, the thousandth and so on.
  std::vector<Fault> Deliver(std::chrono::nanoseconds wait_at_most);

  // How many publish `topic`, as it was called in Subscribe.
  int publishers(const std::string& topic) const;
  // Why nobody does (dds::Publisher::WhyNobody); "": somebody does, or it was
  // not subscribed to.
  std::string WhyNobody(const std::string& topic) const;

  int64_t delivered() const { return delivered_; }
  // Of all topics.
  int64_t refused() const;
  // From writing to delivery, by the clocks of this machine's system: of the
  // last ten thousand messages that were not latched, this share took at most
  // so long. 0 before the first.
  double Delivery_ms(double share) const;

 private:
  struct Input {
    // As it was called.
    std::string topic;
    std::unique_ptr<dds::Subscription> subscription;
    bool is_latched = false;
    std::function<absl::Status(std::span<const uint8_t> bytes)> deliver;
    int64_t refused = 0;
    std::string last_fault = {};
  };
  absl::Status SubscribeRaw(
      const std::string& topic, const std::string& message_name,
      const dds::Quality& quality,
      std::function<absl::Status(std::span<const uint8_t> bytes)> deliver);
  const Input* Find(const std::string& topic) const;
  void NoteDelivery(int64_t written_ns);

  dds::Node& node_;
  std::vector<Input> inputs_;
  int64_t delivered_ = 0;
  // A ring: the newest overwrite the oldest.
  std::vector<double> delivery_ms_;
  size_t next_delivery_ = 0;
};

}  // namespace treeline::topic_inputs

#endif  // NAV_AGENT_BRIDGE_TOPIC_INPUTS_TOPIC_INPUTS_H_

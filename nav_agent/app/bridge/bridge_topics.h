// The topics of a place finder, over DDS.
#ifndef NAV_AGENT_APP_BRIDGE_BRIDGE_TOPICS_H_
#define NAV_AGENT_APP_BRIDGE_BRIDGE_TOPICS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/place_finder/place_finder.h"

namespace treeline::bridge_app {

// Time as ROS 2 has it: of the system, or of /clock. By one thread.
class RosClock final : public base::Clock {
 public:
  explicit RosClock(bool is_simulated) : is_simulated_(is_simulated) {}
  // Simulated time begins with the first message of /clock; 0 before.
  base::MonotonicTime Now() const override;
  void Set(const messages::Clock& clock);
  bool is_simulated() const { return is_simulated_; }

 private:
  bool is_simulated_;
  base::MonotonicTime simulated_;
};

// What came broken, by topic; for the log, once each.
using BrokenMessage =
    std::function<void(const std::string& topic, const absl::Status& why)>;

class BridgeTopics {
 public:
  static absl::StatusOr<std::unique_ptr<BridgeTopics>> Open(
      dds::Node& node, const BridgeConfig& config);

  // Hands over what has come since the last call.
  void Deliver(place_finder::PlaceFinder& finder, RosClock& clock,
               const BrokenMessage& on_broken);
  absl::Status Publish(const messages::PoseWithCovarianceStamped& place);
  absl::Status Publish(const messages::DiagnosticArray& diagnostics);

  int64_t delivered() const { return delivered_; }
  // From writing to delivery, by the clocks of this machine's system: of the
  // last ten thousand messages that were not latched, this share took at most
  // so long. 0 before the first.
  double Delivery_ms(double share) const;

 private:
  struct Input {
    std::unique_ptr<dds::Subscription> subscription;
    bool is_latched = false;
    std::function<absl::Status(const dds::Sample& sample,
                               place_finder::PlaceFinder& finder,
                               RosClock& clock)>
        deliver;
  };

  // deliver(message, finder, clock) gets what is decoded.
  template <typename M, typename DeliverMessage>
  absl::Status Subscribe(dds::Node& node, const std::string& topic,
                         const dds::Quality& quality, DeliverMessage deliver);
  absl::Status SubscribeCamera(dds::Node& node, const BridgeConfig& config);
  void NoteDelivery(int64_t written_ns);

  std::vector<Input> inputs_;
  std::unique_ptr<dds::Publisher> place_;
  std::unique_ptr<dds::Publisher> diagnostics_;
  int64_t delivered_ = 0;
  // A ring: the newest overwrite the oldest.
  std::vector<double> delivery_ms_;
  size_t next_delivery_ = 0;
};

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_BRIDGE_TOPICS_H_

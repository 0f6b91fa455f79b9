// What a node of ROS 2 is on the wire: topics that it writes and reads, with
// the names, types and qualities of service that ROS 2's own nodes match.
#ifndef NAV_AGENT_BRIDGE_DDS_NODE_H_
#define NAV_AGENT_BRIDGE_DDS_NODE_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/quality.h"
#include "nav_agent/bridge/dds/service.h"
#include "nav_agent/bridge/dds/topic_names.h"

namespace treeline::dds {

struct Sample {
  // Its encoding in front (message_codec.h).
  std::vector<uint8_t> bytes;
  // When it was written, by the writer's clock: ns since 1970.
  int64_t written_ns = 0;
};

// Thread-safe.
class Publisher {
 public:
  virtual ~Publisher() = default;
  // The bytes are those of message_codec.h's Encode.
  virtual absl::Status Publish(std::span<const uint8_t> bytes) = 0;
  // Readers that have been found and match.
  virtual int matched() const = 0;
  // Why there are none, as far as others were discovered (endpoints.h); "":
  // there are some.
  virtual std::string WhyNobody() const = 0;
  virtual const std::string& topic() const = 0;
};

// Thread-safe.
class Subscription {
 public:
  virtual ~Subscription() = default;
  // What has come since the last call, oldest first; never waits. Of more than
  // 256 the rest is left for the next call, so that nobody who floods a topic
  // keeps its reader.
  virtual std::vector<Sample> Take() = 0;
  // Writers that have been found and match.
  virtual int matched() const = 0;
  // As Publisher's.
  virtual std::string WhyNobody() const = 0;
  // Samples that were lost on the way, as far as DDS noticed.
  virtual int64_t lost() const = 0;
  virtual const std::string& topic() const = 0;
};

// Thread-safe. Publishers, subscriptions and services may not outlive it.
class Node {
 public:
  static absl::StatusOr<std::unique_ptr<Node>> Create(const Domain& domain,
                                                      const NodeName& name);
  virtual ~Node() = default;

  // topic: as in C++ or Python of ROS 2, before namespace and remapping.
  // message_name: "sensor_msgs/msg/LaserScan".
  virtual absl::StatusOr<std::unique_ptr<Publisher>> Advertise(
      const std::string& topic, const std::string& message_name,
      const Quality& quality) = 0;
  virtual absl::StatusOr<std::unique_ptr<Subscription>> Subscribe(
      const std::string& topic, const std::string& message_name,
      const Quality& quality) = 0;

  // A service as rmw_cyclonedds has it: clients of rmw_fastrtps are not
  // understood, and left alone. service: a name as topics have it.
  // service_type: "action_msgs/srv/CancelGoal".
  virtual absl::StatusOr<std::unique_ptr<Service>> Serve(
      const std::string& service, const std::string& service_type) = 0;

  // Waits until one of the subscriptions or services has something to take, at
  // most so long. True: one has.
  virtual bool Wait(std::chrono::nanoseconds at_most) = 0;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_NODE_H_

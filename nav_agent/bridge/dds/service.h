// The side of a service of ROS 2 that answers: questions come, replies go.
#ifndef NAV_AGENT_BRIDGE_DDS_SERVICE_H_
#define NAV_AGENT_BRIDGE_DDS_SERVICE_H_

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace treeline::dds {

// Who asked, and which of its questions it was; for Reply.
struct RequestId {
  std::array<uint8_t, 16> client = {};
  int64_t sequence = 0;

  bool operator==(const RequestId&) const = default;
};

struct Request {
  RequestId id;
  // As a message's: its encoding in front, and nothing of the client.
  std::vector<uint8_t> bytes;
};

// For one thread.
class Service {
 public:
  virtual ~Service() = default;
  // What has come since the last call, oldest first; never waits. Replies that
  // were kept back are sent by it, too.
  virtual std::vector<Request> Take() = 0;
  // Of a request that was taken, at any later time. Kept back while the client
  // is there and cannot hear it yet; of a client that is gone, dropped. Bytes
  // as Publisher's.
  virtual absl::Status Reply(const RequestId& id,
                             std::span<const uint8_t> bytes) = 0;
  // Requests so far of clients of another implementation of ROS 2's services,
  // which could not be read.
  virtual int64_t not_understood() const = 0;
  virtual const std::string& name() const = 0;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_SERVICE_H_

// The texts and bytes of Foxglove's WebSocket protocol
// (github.com/foxglove/ws-protocol), as far as a server that only
// shows things speaks it.
#ifndef NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_PROTOCOL_H_
#define NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_PROTOCOL_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::foxglove {

// Names in Sec-WebSocket-Protocol, the preferred first; of the newer name the
// part that is spoken here is the same.
inline constexpr absl::string_view kProtocols[] = {"foxglove.websocket.v1",
                                                   "foxglove.sdk.v1"};

// What can be watched. Messages are CDR, their schema text of `ros2msg`.
struct Channel {
  uint32_t id = 0;
  std::string topic;
  std::string schema_name;
  std::string schema;
};

enum class StatusLevel : uint8_t { kInfo = 0, kWarning = 1, kError = 2 };

// A session of another id makes a viewer that comes again forget what it had.
std::string ServerInfoText(absl::string_view name, absl::string_view session);
std::string AdvertiseText(std::span<const Channel> channels);
std::string StatusText(StatusLevel level, absl::string_view message);

// A binary message: time in nanoseconds since 1970.
std::string MessageData(uint32_t subscription, uint64_t time_ns,
                        std::span<const uint8_t> message);

// What a client wants.
struct ClientRequest {
  struct Subscription {
    uint32_t id = 0;
    uint32_t channel = 0;
  };
  std::vector<Subscription> subscribe = {};
  std::vector<uint32_t> unsubscribe = {};
};

// INVALID_ARGUMENT: no JSON, or not as specified. UNIMPLEMENTED names an
// operation that this server does not offer.
absl::StatusOr<ClientRequest> ParseClientText(absl::string_view text);

}  // namespace treeline::foxglove

#endif  // NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_PROTOCOL_H_

// One viewer: what it subscribed to, sent as it comes.
#ifndef NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_SESSION_H_
#define NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_SESSION_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "common/http/web_socket.h"
#include "nav_agent/bridge/foxglove/live_topics.h"

namespace treeline::foxglove {

// For the thread of its connection. While it writes to a viewer that reads
// slowly, states pass; the viewer then gets the newest.
class FoxgloveSession {
 public:
  // Keeps references to all but `topics`.
  FoxgloveSession(const agent_service::AgentHub& hub, LiveTopics topics,
                  const base::Clock& clock, http::HttpDuplex& connection);

  // Returns when the viewer has gone or the hub is closed.
  void Run(absl::string_view server_name, absl::string_view session_id);

 private:
  // False: the viewer has gone.
  bool Text(absl::string_view text);
  // What is new of all that it subscribed to.
  bool Show();
  bool WaitAndRead();
  // Takes the bytes apart that were read.
  bool Parse(absl::string_view bytes);
  bool OnMessage();
  absl::Status Take(const ClientRequest& request);
  void SetArriving(bool is_arriving);

  const agent_service::AgentHub& hub_;
  LiveTopics topics_;
  const base::Clock& clock_;
  http::HttpDuplex& connection_;
  http::WebSocketReader reader_;
  bool is_arriving_ = false;
  // Of the viewer's ids.
  std::map<uint32_t, LiveTopic> subscriptions_;
  // How it ends.
  std::optional<http::WebSocketClose> end_;
};

}  // namespace treeline::foxglove

#endif  // NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_SESSION_H_

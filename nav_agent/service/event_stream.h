// /api/stream: Server-Sent Events.
#ifndef NAV_AGENT_SERVICE_EVENT_STREAM_H_
#define NAV_AGENT_SERVICE_EVENT_STREAM_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/time/time.h"
#include "common/http/http_message.h"
#include "nav_agent/service/agent_hub.h"

namespace treeline::agent_service {

// What was published last, as JSON.
struct StateTexts {
  uint64_t number = 0;
  std::string state;
  std::string scene;
};
using StateTextsOf =
    std::function<std::shared_ptr<const StateTexts>(const AgentState&)>;

// Writes `state` for each state of the hub, `scene` for every second one, and
// `event` for each event, the last 50 that were before it first. Silent for no
// longer than `heartbeat`. Returns when the hub is closed or nobody reads.
void RunEventStream(const AgentHub& hub, const StateTextsOf& texts_of,
                    absl::Duration heartbeat, http::HttpBodyWriter& writer);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_EVENT_STREAM_H_

// The payloads of an agent log's records; docs/reference/agent-log.md specifies
// them.
#ifndef NAV_AGENT_RECORDING_LOG_PAYLOAD_H_
#define NAV_AGENT_RECORDING_LOG_PAYLOAD_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::recording {

struct LogPayload {
  uint16_t kind = 0;
  int64_t stamp_ns = 0;
  std::string bytes;
};

LogPayload EncodeLogPayload(const LogEntry& entry);

// nullopt: of an unknown kind, or not a payload of its kind.
std::optional<LogEntry> DecodeLogPayload(uint16_t kind, int64_t stamp_ns,
                                         absl::string_view bytes);

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_LOG_PAYLOAD_H_

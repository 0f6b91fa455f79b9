// Scans as JSON; see laser_log.h.
#ifndef NAV_AGENT_RECORDING_LASER_LOG_JSON_H_
#define NAV_AGENT_RECORDING_LASER_LOG_JSON_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline::recording {

absl::StatusOr<LaserLog> ParseLaserLogJson(absl::string_view text,
                                           const std::string& name,
                                           const LaserLogOptions& options);

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_LASER_LOG_JSON_H_

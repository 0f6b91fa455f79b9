// Files of drawn zones that people write.
#ifndef NAV_AGENT_APP_ZONES_ZONES_YAML_H_
#define NAV_AGENT_APP_ZONES_ZONES_YAML_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/zones/zone.h"

namespace treeline::zones_app {

// As docs/reference/zones.md has it. INVALID_ARGUMENT: "FILE:LINE: ..."; what a
// zone means on a map the agent says. Safe on any bytes.
absl::StatusOr<std::vector<zones::Zone>> ParseZones(absl::string_view text,
                                                    absl::string_view name);

// What ParseZones reads.
std::string ZonesText(const std::vector<zones::Zone>& zones);

}  // namespace treeline::zones_app

#endif  // NAV_AGENT_APP_ZONES_ZONES_YAML_H_

// Zones, proto <-> C++. Text that is not UTF-8 gets U+FFFD.
#ifndef NAV_AGENT_SERVICE_ZONES_WIRE_H_
#define NAV_AGENT_SERVICE_ZONES_WIRE_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/zones/zone.h"
#include "nav_agent/zones/zone_masks.h"
#include "treeline/v1/zones.pb.h"

namespace treeline::agent_service {

// INVALID_ARGUMENT: no kind that there is. What else it means, CheckZone says.
absl::StatusOr<zones::Zone> FromProto(const v1::Zone& proto);

v1::Zone ToProto(const zones::Zone& zone);
v1::ZoneMask ToProto(const zones::ZoneMask& mask,
                     const std::vector<int32_t>& runs);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_ZONES_WIRE_H_

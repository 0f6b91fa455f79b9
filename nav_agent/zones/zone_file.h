// Drawn zones as bytes that outlive the program.
#ifndef NAV_AGENT_ZONES_ZONE_FILE_H_
#define NAV_AGENT_ZONES_ZONE_FILE_H_

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/zones/zone.h"

namespace treeline::zones {

// A text: a first line, one line a zone, and a last line with their number and
// a checksum of all before it (FNV-1a, 64 bits):
//
//   treeline-zones 1
//   KIND LEVEL MAX_MPS DIRECTION_RAD CORNERS X Y X Y ... NAME
//   end ZONES CHECKSUM
std::string ZoneFileText(std::span<const Zone> zones);
// Zones as they were written, bit for bit. INVALID_ARGUMENT says which line is
// wrong, or that the file was cut off or changed. Safe on any bytes.
absl::StatusOr<std::vector<Zone>> ParseZoneFile(absl::string_view text);

}  // namespace treeline::zones

#endif  // NAV_AGENT_ZONES_ZONE_FILE_H_

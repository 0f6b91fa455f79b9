// Zones as mask files, in the manner of Nav2's costmap filters.
#ifndef NAV_AGENT_ZONES_ZONE_MASKS_H_
#define NAV_AGENT_ZONES_ZONE_MASKS_H_

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/zones/zone.h"

namespace treeline::zones {

// Values over ground, of a map file: base + multiplier * value, where value is
// map_server's occupancy, 0 to 100. Cheap to copy.
struct ZoneMask {
  // The map's file.
  std::string name;
  // kKeepOut or kSpeed.
  ZoneKind kind = ZoneKind::kKeepOut;
  int level = 0;
  double base = 0;
  double multiplier = 1;
  // Of kSpeed: whether values are percents of the robot's speed, or m/s.
  bool is_percent = false;
  std::shared_ptr<const core::ValueGrid> values;

  // Of kKeepOut: whether it keeps out of a place. No value, and what lies
  // outside of the mask, does not.
  bool KeepsOut(std::optional<int> value) const {
    return value.has_value() && base + multiplier * *value >= 50;
  }
  // Of kSpeed (m/s); nullopt: no limit. As Nav2 has it, 0 is none.
  std::optional<double> Limit_mps(std::optional<int> value,
                                  double full_mps) const;
};

// Reads the file that lists masks:
//
//   masks:
//     - file: keepout.yaml        # beside the list, or an absolute path
//       filter: keep-out          # keep-out, speed-percent or speed-mps
//       level: 0
//       base: 0                   # of the speed filters, as Nav2's
//       multiplier: 1
//
// Errors name file and line.
absl::StatusOr<std::vector<ZoneMask>> ReadZoneMasks(const std::string& path);

}  // namespace treeline::zones

#endif  // NAV_AGENT_ZONES_ZONE_MASKS_H_

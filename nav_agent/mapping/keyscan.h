// A scan that is kept, with all that other scans are matched against.
#ifndef NAV_AGENT_MAPPING_KEYSCAN_H_
#define NAV_AGENT_MAPPING_KEYSCAN_H_

#include <memory>
#include <optional>
#include <span>

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/mapping/scan_agreement.h"
#include "nav_agent/mapping/scan_outline.h"
#include "nav_agent/mapping/scan_plane.h"

namespace treeline::mapping {

struct Keyscan {
  std::shared_ptr<const ScanOutline> scan;
  geometry::Rigid2 map_from_base;
  double height_m = 0;
  // Of the ground, in the base's axes.
  geometry::Vec2 slope;
  // The keyscan before it in the front end's eyes; nullopt: none, or nobody
  // knows the way from there.
  std::optional<geometry::Rigid2> previous_from_this = {};

  ScanPlane Plane() const {
    return {.at = map_from_base.translation,
            .height_m = height_m,
            .slope = TurnedBy(map_from_base.yaw_rad, slope)};
  }
  geometry::Vec3 Place() const {
    const geometry::Vec2 at = map_from_base.translation;
    return {at.x, at.y, height_m};
  }
};

// Between a scan and each of the keyscans.
Contradictions ContradictionsWith(std::span<const Keyscan> keyscans,
                                  const ScanOutline& scan,
                                  const geometry::Rigid2& map_from_base);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_KEYSCAN_H_

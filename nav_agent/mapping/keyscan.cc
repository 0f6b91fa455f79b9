#include "nav_agent/mapping/keyscan.h"

namespace treeline::mapping {

Contradictions ContradictionsWith(std::span<const Keyscan> keyscans,
                                  const ScanOutline& scan,
                                  const geometry::Rigid2& map_from_base) {
  const SeenSpace here(scan);
  Contradictions found;
  for (const Keyscan& keyscan : keyscans) {
    found += ContradictionsBetween(
        scan, here, *keyscan.scan, SeenSpace(*keyscan.scan),
        map_from_base.Inverse() * keyscan.map_from_base);
  }
  return found;
}

}  // namespace treeline::mapping

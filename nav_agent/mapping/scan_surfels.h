// A laser scan as short pieces of line, for laying many scans upon each other.
#ifndef NAV_AGENT_MAPPING_SCAN_SURFELS_H_
#define NAV_AGENT_MAPPING_SCAN_SURFELS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/mapping/scan_outline.h"

namespace treeline::mapping {

struct ScanSurfelOptions {
  // Lines are fitted to the joined points within this of each other (m), to at
  // least min_points of them, and are dropped if points are off by more than
  // max_off_m (root mean square).
  double reach_m = 0.25;
  int min_points = 3;
  double max_off_m = 0.03;
  // Along one surface, one is kept in each so many metres.
  double spacing_m = 0.1;
};

// The middle of a piece of line, and the direction at right angles to it that
// the robot is in; in the scan's frame.
struct Surfel {
  float x = 0;
  float y = 0;
  float normal_x = 0;
  float normal_y = 0;
};

// `scan`'s, in its order.
std::vector<Surfel> SurfelsOf(const ScanOutline& scan,
                              const ScanSurfelOptions& options);

// Surfels by place. Immutable: any thread may ask.
class ScanSurfels {
 public:
  explicit ScanSurfels(std::vector<Surfel> surfels);

  std::span<const Surfel> surfels() const { return surfels_; }
  // One that is near to a place in the scan's frame, within kNear_m to twice of
  // it, or nullptr.
  const Surfel* Near(geometry::Vec2 at_m) const;

  static constexpr double kNear_m = 0.15;

 private:
  struct Slot {
    uint32_t cell = 0;
    int16_t surfel = -1;
    float distance2_m2 = 0;
  };

  void Index();
  void Put(int cell_x, int cell_y, size_t surfel);

  std::vector<Surfel> surfels_;
  // A hash table, of cells that are kNear_m wide.
  std::vector<Slot> slots_;
  uint32_t mask_ = 0;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SCAN_SURFELS_H_

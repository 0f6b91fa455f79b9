// Whether scans that a matcher has laid upon each other can be of one place.
#ifndef NAV_AGENT_MAPPING_SCAN_AGREEMENT_H_
#define NAV_AGENT_MAPPING_SCAN_AGREEMENT_H_

#include <array>

#include "common/geometry/rigid2.h"
#include "nav_agent/mapping/scan_outline.h"
#include "nav_agent/mapping/surface_grid.h"

namespace treeline::mapping {

// A scan runs counter-clockwise, so that the robot is always to the left of the
// surface that it sees. The share of the query's surfaces that lie on pieces of
// the grid which were seen from the same side: the two faces of a wall, or the
// inner and the outer corner of a corridor, look alike to a matcher of points.
// 0 if there are too few to tell.
double ShareOfSameSide(const SurfaceGrid& grid, const ScanOutline& query,
                       const geometry::Rigid2& target_from_query);

// Points that another scan can tell of, and those of them that stand where it
// looked through: things that were not there, or a place that is not this one.
struct Contradictions {
  int told = 0;
  int contradicted = 0;

  // Of those that are told; 0 if none is.
  double Share() const {
    return told > 0 ? static_cast<double>(contradicted) / told : 0;
  }
  Contradictions& operator+=(const Contradictions& other) {
    told += other.told;
    contradicted += other.contradicted;
    return *this;
  }
};

// The space that a scan looked through, by direction. Immutable: any thread may
// ask.
class SeenSpace {
 public:
  explicit SeenSpace(const ScanOutline& scan);

  // A point is contradicted if all within kClear_m of it was looked through,
  // which small errors of the pose and beams along walls do not bring about; it
  // is told if it is nearer than what was seen in its direction, or at it.
  // Points farther than kFarthest_m away, where a small turn is a long way, do
  // not count.
  Contradictions Contradicted(const ScanOutline& other,
                              const geometry::Rigid2& this_from_other) const;

  static constexpr double kClear_m = 0.25;
  static constexpr double kFarthest_m = 8;

 private:
  static constexpr int kDirections = 720;

  void SetSeen(const ScanOutline& scan);
  void FillGaps();
  void SetClear();

  geometry::Vec2 seen_from_;
  // By direction, from -pi on: how far it was seen (m; 0: not at all), and up
  // to where all is clear.
  std::array<float, kDirections> seen_m_{};
  std::array<float, kDirections> clear_m_{};
};

// What two scans tell of each other.
Contradictions ContradictionsBetween(const ScanOutline& a,
                                     const SeenSpace& seen_by_a,
                                     const ScanOutline& b,
                                     const SeenSpace& seen_by_b,
                                     const geometry::Rigid2& a_from_b);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SCAN_AGREEMENT_H_

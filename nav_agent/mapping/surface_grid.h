// How near every place is to a surface that reference scans have seen.
#ifndef NAV_AGENT_MAPPING_SURFACE_GRID_H_
#define NAV_AGENT_MAPPING_SURFACE_GRID_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/mapping/scan_outline.h"

namespace treeline::mapping {

// A scan at its place in the frame that it is a reference in.
struct PlacedScan {
  const ScanOutline* scan = nullptr;
  geometry::Rigid2 target_from_scan;
};

// A lookup grid: each cell holds exp(-d^2 / (2 sigma^2)), scaled to 255, for
// the distance d of its centre to the nearest surface, 0 beyond kReach sigma,
// and which surface that is. Surfaces are the pieces between joined points;
// points of their own are pieces of length 0.
//
// Level h of the pyramid holds at (x, y) the largest of the 2^h x 2^h cells
// from there on, which bounds the response of all poses that are up to that
// many cells farther (Hess et al., "Real-Time Loop Closure in 2D LIDAR SLAM",
// ICRA 2016).
class SurfaceGrid {
 public:
  static constexpr double kReach = 3.0;

  struct Piece {
    geometry::Vec2 begin;
    geometry::Vec2 end;
  };

  // Axes as the target's. Of the square that is 2 * half_extent_m wide about
  // the centre, the cells from one corner to the other.
  SurfaceGrid(geometry::Vec2 center_in_target, double half_extent_m,
              geometry::Vec2 low_in_target, geometry::Vec2 high_in_target,
              double cell_m, double sigma_m);

  void Draw(const PlacedScan& scan);
  // After all drawing: levels 0 to `levels` - 1.
  void BuildPyramid(int levels);

  int width() const { return width_; }
  int height() const { return height_; }
  double cell_m() const { return cell_m_; }
  double sigma_m() const { return sigma_m_; }
  geometry::Vec2 origin() const { return origin_; }  // the lower left corner
  int levels() const { return static_cast<int>(levels_.size()); }
  const uint8_t* level(int h) const {
    return levels_[static_cast<size_t>(h)].data();
  }
  // The nearest piece to a place, or nothing if none is in reach.
  const Piece* NearestPiece(geometry::Vec2 point_in_target) const;

 private:
  void DrawPiece(const Piece& piece);
  void WriteLevel0();

  double cell_m_;
  double sigma_m_;
  int width_;
  int height_;
  geometry::Vec2 origin_;
  std::vector<std::vector<uint8_t>> levels_;
  // As DrawSegment has them.
  std::vector<uint32_t> nearest_;
  // What has been drawn on: columns and rows, the last ones too.
  int drawn_left_;
  int drawn_right_ = -1;
  int drawn_bottom_;
  int drawn_top_ = -1;
  std::vector<Piece> pieces_;
  // 255 exp(...) by squared distance in 1 / steps_per_cell2_ of a cell squared.
  std::vector<uint8_t> table_;
  double steps_per_cell2_;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SURFACE_GRID_H_

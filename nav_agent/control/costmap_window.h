// The cells around the robot: where they are, and their numbers.
#ifndef NAV_AGENT_CONTROL_COSTMAP_WINDOW_H_
#define NAV_AGENT_CONTROL_COSTMAP_WINDOW_H_

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/occupancy_grid.h"

namespace treeline::control {

// A rectangle of cells with the map's axes that rolls along with the robot, by
// whole cells, so that what is kept of a cell stays that cell's. Cells are
// numbered along x first. A value: pure, thread-safe.
class CostmapWindow {
 public:
  // Centred on the map's origin.
  CostmapWindow(double length_m, double width_m, double resolution_m)
      : resolution_m_(resolution_m),
        width_(static_cast<int>(std::lround(length_m / resolution_m))),
        height_(static_cast<int>(std::lround(width_m / resolution_m))) {}

  // The same, with a place in the map in its middle cell.
  CostmapWindow CenteredAt(geometry::Vec2 at) const {
    CostmapWindow window = *this;
    const double r = resolution_m_;
    window.cell_x_ = static_cast<int64_t>(std::llround(at.x / r)) - width_ / 2;
    window.cell_y_ = static_cast<int64_t>(std::llround(at.y / r)) - height_ / 2;
    window.origin_in_map_ = {static_cast<double>(window.cell_x_) * r,
                             static_cast<double>(window.cell_y_) * r};
    return window;
  }

  // Cells along the map's x, and along its y; of a cell's side (m).
  int width() const { return width_; }
  int height() const { return height_; }
  double resolution_m() const { return resolution_m_; }
  size_t cells() const {
    return static_cast<size_t>(width_) * static_cast<size_t>(height_);
  }
  // The lower left corner: in m, and in whole cells from the map's origin.
  geometry::Vec2 origin_in_map() const { return origin_in_map_; }
  int64_t cell_x() const { return cell_x_; }
  int64_t cell_y() const { return cell_y_; }
  bool IsSamePlaceAs(const CostmapWindow& other) const {
    return cell_x_ == other.cell_x_ && cell_y_ == other.cell_y_;
  }

  size_t IndexOf(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) +
           static_cast<size_t>(x);
  }
  bool IsInside(int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_;
  }
  bool IsInside(core::CellIndex cell) const { return IsInside(cell.x, cell.y); }
  core::CellIndex CellOf(geometry::Vec2 point_in_map) const {
    return {static_cast<int>(std::floor((point_in_map.x - origin_in_map_.x) /
                                        resolution_m_)),
            static_cast<int>(std::floor((point_in_map.y - origin_in_map_.y) /
                                        resolution_m_))};
  }
  geometry::Vec2 CenterInMap(int x, int y) const {
    return {origin_in_map_.x + (x + 0.5) * resolution_m_,
            origin_in_map_.y + (y + 0.5) * resolution_m_};
  }
  // Whether a point is in the window, `inset_m` from its edge.
  bool Contains(geometry::Vec2 point_in_map, double inset_m = 0) const {
    const geometry::Vec2 from = point_in_map - origin_in_map_;
    return from.x >= inset_m && from.y >= inset_m &&
           from.x < width_ * resolution_m_ - inset_m &&
           from.y < height_ * resolution_m_ - inset_m;
  }

 private:
  double resolution_m_;
  int width_;
  int height_;
  int64_t cell_x_ = 0;
  int64_t cell_y_ = 0;
  geometry::Vec2 origin_in_map_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_COSTMAP_WINDOW_H_

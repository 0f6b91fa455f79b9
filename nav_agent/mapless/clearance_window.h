// How far it is to the nearest thing, in a part of the evidence grid.
#ifndef NAV_AGENT_MAPLESS_CLEARANCE_WINDOW_H_
#define NAV_AGENT_MAPLESS_CLEARANCE_WINDOW_H_

#include <vector>

#include "nav_agent/mapless/evidence_grid.h"

namespace treeline::mapless {

// Immutable once made.
class ClearanceWindow {
 public:
  ClearanceWindow() = default;
  // The cells of `map` from low to high, which may reach beyond it.
  ClearanceWindow(const EvidenceGrid& map, geometry::Vec2 low,
                  geometry::Vec2 high);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double cell_m() const { return cell_m_; }
  geometry::Vec2 origin() const { return origin_; }
  // From the middle of the point's cell to that of the nearest with something
  // in it (m), at most kFar_m; outside of the window, too, it is that.
  static constexpr double kFar_m = 5;
  double At(geometry::Vec2 point) const {
    const auto x = static_cast<int>((point.x - origin_.x) * per_m_);
    const auto y = static_cast<int>((point.y - origin_.y) * per_m_);
    if (x < 0 || x >= columns_ || y < 0 || y >= rows_) return kFar_m;
    return static_cast<double>(
        distance_m_[static_cast<size_t>(y) * static_cast<size_t>(columns_) +
                    static_cast<size_t>(x)]);
  }
  const std::vector<float>& cells() const { return distance_m_; }

 private:
  int columns_ = 0;
  int rows_ = 0;
  double cell_m_ = 1;
  double per_m_ = 1;
  geometry::Vec2 origin_;
  std::vector<float> distance_m_;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_CLEARANCE_WINDOW_H_

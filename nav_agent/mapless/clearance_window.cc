#include "nav_agent/mapless/clearance_window.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/core/distance_field.h"

namespace treeline::mapless {

ClearanceWindow::ClearanceWindow(const EvidenceGrid& map, geometry::Vec2 low,
                                 geometry::Vec2 high)
    : cell_m_(map.cell_m()), per_m_(1 / map.cell_m()) {
  const core::CellIndex first = map.CellOf(low);
  const core::CellIndex last = map.CellOf(high);
  columns_ = last.x - first.x + 1;
  rows_ = last.y - first.y + 1;
  origin_ = map.CenterOf(first) - geometry::Vec2{cell_m_ / 2, cell_m_ / 2};
  const std::vector<int32_t> squared = core::SquaredDistances(
      columns_, rows_, map.ObstaclesIn(first.x, first.y, columns_, rows_));
  distance_m_.resize(squared.size());
  for (size_t i = 0; i < squared.size(); ++i) {
    distance_m_[i] = static_cast<float>(std::min(
        kFar_m, squared[i] == core::kNoObstacle
                    ? kFar_m
                    : cell_m_ * std::sqrt(static_cast<double>(squared[i]))));
  }
}

}  // namespace treeline::mapless

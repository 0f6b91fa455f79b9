#include "nav_agent/control/distance_layer.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/core/distance_field.h"

namespace treeline::control {

DistanceLayer::DistanceLayer(const CostmapWindow& window,
                             const Footprint& footprint)
    : window_(window),
      footprint_(footprint),
      edge_in_base_(footprint.Edge(window.resolution_m())),
      area_in_base_(footprint.Area(kCellStep * window.resolution_m())),
      distance_m_(window.cells(), 0.0F) {}

void DistanceLayer::Measure(const CostmapWindow& window,
                            std::span<const uint8_t> is_obstacle,
                            double far_m) {
  window_ = window;
  const std::vector<int32_t> squared =
      core::SquaredDistances(window.width(), window.height(), is_obstacle);
  for (size_t i = 0; i < squared.size(); ++i) {
    distance_m_[i] =
        squared[i] == core::kNoObstacle
            ? static_cast<float>(far_m)
            : static_cast<float>(window.resolution_m() *
                                 std::sqrt(static_cast<double>(squared[i])));
  }
}

double DistanceLayer::Distance_m(geometry::Vec2 point_in_map) const {
  const double r = window_.resolution_m();
  const geometry::Vec2 origin = window_.origin_in_map();
  const int width = window_.width();
  const int height = window_.height();
  const double x = (point_in_map.x - origin.x) / r - 0.5;
  const double y = (point_in_map.y - origin.y) / r - 0.5;
  if (!(x >= -0.5 && y >= -0.5 && x <= width - 0.5 && y <= height - 0.5)) {
    return -r;
  }
  const int left = std::clamp(static_cast<int>(x), 0, width - 2);
  const int below = std::clamp(static_cast<int>(y), 0, height - 2);
  const double right_part = std::clamp(x - left, 0.0, 1.0);
  const double above_part = std::clamp(y - below, 0.0, 1.0);
  const size_t i = window_.IndexOf(left, below);
  const auto row = static_cast<size_t>(width);
  const double lower =
      (1 - right_part) * distance_m_[i] + right_part * distance_m_[i + 1];
  const double upper = (1 - right_part) * distance_m_[i + row] +
                       right_part * distance_m_[i + row + 1];
  return (1 - above_part) * lower + above_part * upper - 0.5 * r;
}

geometry::Vec2 DistanceLayer::Away(geometry::Vec2 point_in_map) const {
  const double r = window_.resolution_m();
  const geometry::Vec2 gradient = {
      Distance_m({point_in_map.x + r, point_in_map.y}) -
          Distance_m({point_in_map.x - r, point_in_map.y}),
      Distance_m({point_in_map.x, point_in_map.y + r}) -
          Distance_m({point_in_map.x, point_in_map.y - r})};
  const double length = geometry::Norm(gradient);
  return length < 1e-6 ? geometry::Vec2{} : (1 / length) * gradient;
}

bool DistanceLayer::IsObstacle(geometry::Vec2 point_in_map) const {
  const core::CellIndex cell = window_.CellOf(point_in_map);
  return !window_.IsInside(cell) ||
         distance_m_[window_.IndexOf(cell.x, cell.y)] <= 0;
}

double DistanceLayer::FootprintDistance_m(const geometry::Rigid2& map_from_base,
                                          double max_distance_m) const {
  const double from_center_m = Distance_m(map_from_base.translation);
  const double circumradius_m = footprint_.Circumradius_m();
  if (from_center_m > circumradius_m + max_distance_m) return max_distance_m;
  const double c = std::cos(map_from_base.yaw_rad);
  const double s = std::sin(map_from_base.yaw_rad);
  const geometry::Vec2 at = map_from_base.translation;
  const auto in_map = [&](geometry::Vec2 p) {
    return geometry::Vec2{at.x + c * p.x - s * p.y, at.y + s * p.x + c * p.y};
  };
  double min_distance_m = max_distance_m;
  for (const geometry::Vec2& point : edge_in_base_) {
    min_distance_m = std::min(min_distance_m, Distance_m(in_map(point)));
  }
  // Something small may stand within.
  if (min_distance_m > 0 && from_center_m < circumradius_m) {
    for (const geometry::Vec2& point : area_in_base_) {
      if (!IsObstacle(in_map(point))) continue;
      return std::min(-window_.resolution_m(),
                      -footprint_.Inradius_m() + from_center_m);
    }
  }
  return min_distance_m;
}

}  // namespace treeline::control

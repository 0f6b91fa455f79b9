#include "nav_agent/control/zone_layer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {

ZoneLayer::ZoneLayer(size_t cells, const Footprint& footprint)
    : footprint_in_base_(footprint.Area(kZoneFootprintStep_m)),
      circumradius_m_(footprint.Circumradius_m()),
      way_out_m_(cells, 0.0F) {}

void ZoneLayer::SetZones(std::shared_ptr<const zones::ZoneMap> zones) {
  zones_ = std::move(zones);
  has_closed_ = false;
  if (zones_ == nullptr) return;
  const geometry::Rigid2& map_from_grid = zones_->grid().map_from_grid;
  cos_ = std::cos(map_from_grid.yaw_rad);
  sin_ = std::sin(map_from_grid.yaw_rad);
  origin_ = map_from_grid.translation;
}

core::CellIndex ZoneLayer::MapCellAt(geometry::Vec2 point_in_map) const {
  const geometry::Vec2 from = point_in_map - origin_;
  const double scale = 1 / zones_->grid().resolution_m;
  return {
      static_cast<int>(std::floor(scale * (cos_ * from.x + sin_ * from.y))),
      static_cast<int>(std::floor(scale * (-sin_ * from.x + cos_ * from.y)))};
}

void ZoneLayer::Spread(const CostmapWindow& window, const GroundLayer& ground) {
  has_closed_ = false;
  // Where it is lost, nobody knows where zones are.
  if (!KeepsOut() || ground.map_is_unknown()) return;
  for (int y = 0; y < window.height(); ++y) {
    for (int x = 0; x < window.width(); ++x) {
      const size_t i = window.IndexOf(x, y);
      const std::optional<core::LevelPlace> place = ground.PlaceAt(i);
      way_out_m_[i] =
          place.has_value()
              ? zones_->WayOut_m(place->level,
                                 MapCellAt(window.CenterInMap(x, y)))
              : 0.0F;
      has_closed_ = has_closed_ || way_out_m_[i] > 0;
    }
  }
}

void ZoneLayer::LetOut(const CostmapWindow& window, const GroundLayer& ground,
                       const core::LevelPose& pose) {
  let_out_m_ = 0;
  if (!has_closed_) return;
  const geometry::Rigid2& map_from_base = pose.map_from_base;
  const auto way_out_m = [&](geometry::Vec2 in_base) {
    const core::CellIndex cell = window.CellOf(map_from_base * in_base);
    if (!window.IsInside(cell)) return 0.0F;
    const size_t i = window.IndexOf(cell.x, cell.y);
    return ground.IsGround(i) ? way_out_m_[i] : 0.0F;
  };
  float longest_m = 0;
  for (const geometry::Vec2& in_base : footprint_in_base_) {
    const float way_m = way_out_m(in_base);
    if (std::isfinite(way_m)) longest_m = std::max(longest_m, way_m);
  }
  const float middle_m = way_out_m({0, 0});
  // It may turn where it stands.
  if (middle_m > 0) {
    longest_m =
        std::max(longest_m, middle_m + static_cast<float>(circumradius_m_));
  }
  if (longest_m > 0) {
    let_out_m_ = longest_m + static_cast<float>(kZoneSlack_m.value);
  }
}

std::vector<geometry::Vec2> ZoneLayer::Edges(const core::LevelPose& pose,
                                             double radius_m) const {
  std::vector<geometry::Vec2> edges;
  const geometry::Vec2 at = pose.map_from_base.translation;
  const int level = pose.place.level;
  if (!KeepsOut()) return edges;
  const core::CellIndex middle = MapCellAt(at);
  if (zones_->IsKeptOut(level, middle)) return edges;
  const int reach =
      static_cast<int>(radius_m / zones_->grid().resolution_m) + 1;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      const auto is_out = [&](int beside_x, int beside_y) {
        return !zones_->IsKeptOut(level, core::CellIndex{beside_x, beside_y});
      };
      if (is_out(x, y)) continue;
      if (!is_out(x - 1, y) && !is_out(x + 1, y) && !is_out(x, y - 1) &&
          !is_out(x, y + 1)) {
        continue;
      }
      const geometry::Vec2 center = zones_->grid().CenterInMap({x, y});
      if (geometry::Norm(center - at) <= radius_m) edges.push_back(center);
    }
  }
  return edges;
}

}  // namespace treeline::control

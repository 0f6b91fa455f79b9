#include "nav_agent/mapping/traversed_ground.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::mapping {

int32_t TraversedGround::IndexOf(double at_m) const {
  // Beyond this there is no map.
  constexpr double kMaxCellIndex = 1e9;
  return static_cast<int32_t>(
      std::clamp(std::floor(at_m / reach_m_), -kMaxCellIndex, kMaxCellIndex));
}

void TraversedGround::Add(geometry::Vec3 base_in_map) {
  places_[CellOf(IndexOf(base_in_map.x), IndexOf(base_in_map.y))].push_back(
      base_in_map);
  lowest_m_ = std::min(lowest_m_, base_in_map.z);
  highest_m_ = std::max(highest_m_, base_in_map.z);
}

void TraversedGround::Clear() { *this = TraversedGround(reach_m_); }

bool TraversedGround::IsNear(geometry::Vec3 point_in_map,
                             double margin_m) const {
  if (!(point_in_map.z <= highest_m_ + margin_m) ||
      !(point_in_map.z >= lowest_m_ - margin_m)) {
    return false;
  }
  const int32_t x = IndexOf(point_in_map.x);
  const int32_t y = IndexOf(point_in_map.y);
  for (int32_t dy = -1; dy <= 1; ++dy) {
    for (int32_t dx = -1; dx <= 1; ++dx) {
      const auto cell = places_.find(CellOf(x + dx, y + dy));
      if (cell == places_.end()) continue;
      for (const geometry::Vec3& place : cell->second) {
        if (std::abs(place.z - point_in_map.z) <= margin_m &&
            std::hypot(place.x - point_in_map.x, place.y - point_in_map.y) <=
                reach_m_) {
          return true;
        }
      }
    }
  }
  return false;
}

std::vector<float> WithoutGround(std::span<const float> ranges_m,
                                 const core::RangeSensorInfo& laser,
                                 const geometry::Rigid3& map_from_laser,
                                 const TraversedGround& ground,
                                 double margin_m) {
  std::vector<float> kept(ranges_m.begin(), ranges_m.end());
  for (size_t i = 0; i < kept.size(); ++i) {
    const double range_m = kept[i];
    if (!std::isfinite(range_m)) continue;
    const double angle_rad = laser.AngleOf_rad(static_cast<int>(i));
    const geometry::Vec3 end_in_laser = {range_m * std::cos(angle_rad),
                                         range_m * std::sin(angle_rad), 0};
    if (ground.IsNear(map_from_laser * end_in_laser, margin_m)) {
      kept[i] = core::kInvalidRange;
    }
  }
  return kept;
}

}  // namespace treeline::mapping

#include "nav_agent/mapless/body_shape.h"

#include <algorithm>
#include <cmath>

namespace treeline::mapless {
namespace {

constexpr double kRimStep_m = 0.05;

}  // namespace

BodyShape::BodyShape(const core::RobotModel& robot, double margin_m)
    : margin_m_(margin_m),
      low_{-robot.rear_m, -robot.half_width_m},
      high_{robot.front_m, robot.half_width_m},
      inner_m_(std::min({robot.front_m, robot.rear_m, robot.half_width_m}) +
               margin_m),
      outer_m_(robot.Circumradius_m() + margin_m) {
  const auto along = [this](geometry::Vec2 from, geometry::Vec2 to) {
    const double length_m = geometry::Norm(to - from);
    const int steps = std::max(1, static_cast<int>(length_m / kRimStep_m));
    for (int i = 0; i < steps; ++i) {
      rim_.push_back(from + (static_cast<double>(i) / steps) * (to - from));
    }
  };
  const geometry::Vec2 corners[] = {{robot.front_m, robot.half_width_m},
                                    {-robot.rear_m, robot.half_width_m},
                                    {-robot.rear_m, -robot.half_width_m},
                                    {robot.front_m, -robot.half_width_m}};
  for (int i = 0; i < 4; ++i) along(corners[i], corners[(i + 1) % 4]);
}

double BodyShape::RoomAt_m(const ClearanceWindow& clearance,
                           const geometry::Rigid2& map_from_base,
                           double wanted_m) const {
  const double center_m = clearance.At(map_from_base.translation);
  // No point of the rim is nearer to anything than this.
  if (center_m - outer_m_ >= wanted_m) return wanted_m;
  double room_m = std::min(wanted_m, center_m - inner_m_);
  if (room_m < 0) return room_m;
  const double c = std::cos(map_from_base.yaw_rad);
  const double s = std::sin(map_from_base.yaw_rad);
  for (const geometry::Vec2 point : rim_) {
    const geometry::Vec2 in_map = {
        map_from_base.translation.x + c * point.x - s * point.y,
        map_from_base.translation.y + s * point.x + c * point.y};
    room_m = std::min(room_m, clearance.At(in_map) - margin_m_);
    if (room_m < 0) break;
  }
  return room_m;
}

double BodyShape::DistanceTo_m(const geometry::Rigid2& map_from_base,
                               geometry::Vec2 point_in_map) const {
  const geometry::Vec2 at = map_from_base.Inverse() * point_in_map;
  return std::hypot(std::max({0.0, low_.x - at.x, at.x - high_.x}),
                    std::max({0.0, low_.y - at.y, at.y - high_.y}));
}

}  // namespace treeline::mapless

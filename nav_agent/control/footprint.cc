#include "nav_agent/control/footprint.h"

#include <optional>
#include <utility>

namespace treeline::control {
namespace {

int Pieces(double length_m, double spacing_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / spacing_m - 1e-9)));
}

// The part of a side from `from` to `until` (along it) that is within reach_m
// of a point `beside_m` away from the side's line, at `along`; nullopt: none.
std::optional<std::pair<double, double>> PartNear(double from, double until,
                                                  double along, double beside_m,
                                                  double reach_m) {
  if (std::abs(beside_m) >= reach_m) return std::nullopt;
  const double half = std::sqrt(reach_m * reach_m - beside_m * beside_m);
  const double first = std::max(from, along - half);
  const double last = std::min(until, along + half);
  if (first > last) return std::nullopt;
  return std::pair(first, last);
}

}  // namespace

double Footprint::OutwardSpeed_mps(const core::VelocityCommand& motion,
                                   geometry::Vec2 point_in_base,
                                   double reach_m) const {
  const double v = motion.forward_mps;
  const double w = motion.yaw_rate_radps;
  const auto [x, y] = point_in_base;
  double max_edge_speed_mps = 0;
  // Front and rear: v - w y outwards and inwards; sides: w x. Along a side
  // both are fastest at an end.
  for (const double sign : {1.0, -1.0}) {
    const double end_x = sign > 0 ? front_m : -rear_m;
    if (const auto part =
            PartNear(-half_width_m, half_width_m, y, x - end_x, reach_m)) {
      max_edge_speed_mps =
          std::max({max_edge_speed_mps, sign * (v - w * part->first),
                    sign * (v - w * part->second)});
    }
    if (const auto part =
            PartNear(-rear_m, front_m, x, y - sign * half_width_m, reach_m)) {
      max_edge_speed_mps = std::max({max_edge_speed_mps, sign * w * part->first,
                                     sign * w * part->second});
    }
  }
  return max_edge_speed_mps;
}

std::vector<geometry::Vec2> Footprint::Edge(double spacing_m) const {
  std::vector<geometry::Vec2> points;
  const int along = Pieces(front_m + rear_m, spacing_m);
  for (int i = 0; i <= along; ++i) {
    const double x = -rear_m + (front_m + rear_m) * i / along;
    points.push_back({x, -half_width_m});
    points.push_back({x, half_width_m});
  }
  const int across = Pieces(2 * half_width_m, spacing_m);
  for (int i = 1; i < across; ++i) {
    const double y = -half_width_m + 2 * half_width_m * i / across;
    points.push_back({-rear_m, y});
    points.push_back({front_m, y});
  }
  return points;
}

std::vector<geometry::Vec2> Footprint::Area(double spacing_m) const {
  std::vector<geometry::Vec2> points;
  const int along = Pieces(front_m + rear_m, spacing_m);
  const int across = Pieces(2 * half_width_m, spacing_m);
  for (int i = 0; i <= along; ++i) {
    for (int j = 0; j <= across; ++j) {
      points.push_back({-rear_m + (front_m + rear_m) * i / along,
                        -half_width_m + 2 * half_width_m * j / across});
    }
  }
  return points;
}

}  // namespace treeline::control

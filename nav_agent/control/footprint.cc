#include "nav_agent/control/footprint.h"

namespace treeline {
namespace {

int Pieces(double length_m, double spacing_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / spacing_m - 1e-9)));
}

}  // namespace

std::vector<Vec2> Footprint::Edge(double spacing_m) const {
  std::vector<Vec2> points;
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

std::vector<Vec2> Footprint::Area(double spacing_m) const {
  std::vector<Vec2> points;
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

}  // namespace treeline

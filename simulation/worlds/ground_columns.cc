#include "simulation/worlds/ground_columns.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace treeline::worlds {
namespace {

// Columns are cut a little wider, so that what lies on a border between two is
// in both.
constexpr float kWider_m = 1e-4f;

// A convex polygon: a quadrilateral cut by four planes has at most 8 corners.
struct Polygon {
  std::array<Float3, 12> corners;
  size_t count = 0;

  void Add(Float3 corner) {
    if (count < corners.size()) corners[count++] = corner;
  }
};

// What is left where coordinate * sign >= limit * sign.
template <typename Coordinate>
Polygon Cut(const Polygon& polygon, Coordinate coordinate, float limit,
            float sign) {
  Polygon cut;
  for (size_t i = 0; i < polygon.count; ++i) {
    const Float3 a = polygon.corners[i];
    const Float3 b = polygon.corners[(i + 1) % polygon.count];
    const float da = sign * (coordinate(a) - limit);
    const float db = sign * (coordinate(b) - limit);
    if (da >= 0) cut.Add(a);
    if ((da >= 0) != (db >= 0)) cut.Add(Mix(a, b, da / (da - db)));
  }
  return cut;
}

float X(Float3 p) { return p.x; }
float Y(Float3 p) { return p.y; }

template <typename Coordinate>
std::array<float, 2> Range(const Polygon& polygon, Coordinate coordinate) {
  std::array<float, 2> range = {coordinate(polygon.corners[0]),
                                coordinate(polygon.corners[0])};
  for (size_t i = 1; i < polygon.count; ++i) {
    range[0] = std::min(range[0], coordinate(polygon.corners[i]));
    range[1] = std::max(range[1], coordinate(polygon.corners[i]));
  }
  return range;
}

// Calls visit(cell, span) for each column that a surface is in.
template <typename Visit>
void VisitColumns(const Surface& surface, uint32_t index, int width, int height,
                  float side, Visit visit) {
  Polygon whole;
  for (const Float3& corner : surface.corners) whole.Add(corner);
  const auto cells = [side](std::array<float, 2> range, int count) {
    return std::array<int, 2>{
        std::max(0, static_cast<int>(std::floor((range[0] - kWider_m) / side))),
        std::min(count - 1,
                 static_cast<int>(std::floor((range[1] + kWider_m) / side)))};
  };
  const auto [y0, y1] = cells(Range(whole, Y), height);
  for (int y = y0; y <= y1; ++y) {
    const float row = static_cast<float>(y) * side;
    const Polygon strip =
        Cut(Cut(whole, Y, row - kWider_m, 1), Y, row + side + kWider_m, -1);
    if (strip.count == 0) continue;
    const auto [x0, x1] = cells(Range(strip, X), width);
    for (int x = x0; x <= x1; ++x) {
      const float column = static_cast<float>(x) * side;
      const Polygon piece = Cut(Cut(strip, X, column - kWider_m, 1), X,
                                column + side + kWider_m, -1);
      if (piece.count == 0) continue;
      const auto [low, high] = Range(piece, [](Float3 p) { return p.z; });
      visit(static_cast<size_t>(y) * static_cast<size_t>(width) +
                static_cast<size_t>(x),
            ColumnSpan{low, high, index});
    }
  }
}

}  // namespace

GroundColumns::GroundColumns(const World& world, int width, int height,
                             double resolution_m)
    : first_(static_cast<size_t>(width) * static_cast<size_t>(height) + 1) {
  const float side = static_cast<float>(resolution_m);
  const auto for_all = [&](auto visit) {
    for (size_t i = 0; i < world.surfaces.size(); ++i) {
      VisitColumns(world.surfaces[i], static_cast<uint32_t>(i), width, height,
                   side, visit);
    }
  };
  // Counted first, then filled in.
  for_all([&](size_t cell, const ColumnSpan&) { ++first_[cell + 1]; });
  for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  spans_.resize(first_.back());
  std::vector<size_t> next = first_;
  for_all([&](size_t cell, const ColumnSpan& span) {
    spans_[next[cell]++] = span;
  });
}

bool HeightOnSurface(const Surface& surface, float x, float y,
                     float& height_m) {
  const Float3 normal = surface.Normal();
  if (!(std::abs(normal.z) > 0.1f)) return false;
  // Inside of a convex polygon: on the same side of all edges.
  constexpr float kSlack_m2 = 1e-5f;
  bool has_left = false;
  bool has_right = false;
  for (size_t i = 0; i < 4; ++i) {
    const Float3 a = surface.corners[i];
    const Float3 b = surface.corners[(i + 1) % 4];
    const float side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    has_left |= side > kSlack_m2;
    has_right |= side < -kSlack_m2;
  }
  if (has_left && has_right) return false;
  const Float3 corner = surface.corners[0];
  height_m = corner.z -
             (normal.x * (x - corner.x) + normal.y * (y - corner.y)) / normal.z;
  return true;
}

}  // namespace treeline::worlds

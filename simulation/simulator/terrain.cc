#include "simulation/simulator/terrain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::simulator {
namespace {

constexpr double kCell_m = 0.5;
constexpr double kCarryingNormalZ = 0.70710678;
// Surfaces that meet share corners in single precision: a wheel that runs
// along the seam must find one of them.
constexpr double kSeam_m = 1e-4;

geometry::Vec3 ToVec3(worlds::Float3 a) { return {a.x, a.y, a.z}; }

// Whether (x, y) is within the quadrilateral as seen from above.
bool CoversFromAbove(const TerrainQuad& quad, geometry::Vec2 at) {
  int side = 0;
  for (size_t i = 0; i < 4; ++i) {
    const geometry::Vec3& a = quad.corners[i];
    const geometry::Vec3& b = quad.corners[(i + 1) % 4];
    const geometry::Vec2 edge = {b.x - a.x, b.y - a.y};
    const double length = Norm(edge);
    if (length < 1e-9) continue;
    const double off_m = Cross(edge, at - geometry::Vec2{a.x, a.y}) / length;
    if (std::abs(off_m) <= kSeam_m) continue;
    const int this_side = off_m > 0 ? 1 : -1;
    if (side == -this_side) return false;
    side = this_side;
  }
  return true;
}

double HeightAt(const TerrainQuad& quad, geometry::Vec2 at) {
  const geometry::Vec3& corner = quad.corners[0];
  return corner.z - (quad.normal.x * (at.x - corner.x) +
                     quad.normal.y * (at.y - corner.y)) /
                        quad.normal.z;
}

// The diagonals' cross product: also right for quadrilaterals with two equal
// corners.
geometry::Vec3 UpwardNormal(const QuadCorners& c) {
  const geometry::Vec3 normal = Cross(c[2] - c[0], c[3] - c[1]);
  const double length = Norm(normal);
  if (!(length > 0)) return {1, 0, 0};
  return normal / (normal.z < 0 ? -length : length);
}

}  // namespace

TerrainQuad TerrainQuadOf(const worlds::Surface& surface) {
  TerrainQuad quad;
  for (size_t i = 0; i < 4; ++i) quad.corners[i] = ToVec3(surface.corners[i]);
  quad.bounds = BoundsOf(quad.corners);
  quad.normal = UpwardNormal(quad.corners);
  quad.kind = surface.kind;
  quad.carries = quad.normal.z > kCarryingNormalZ;
  return quad;
}

Terrain::Terrain(const worlds::World& world) {
  quads_.reserve(world.surfaces.size());
  for (const worlds::Surface& surface : world.surfaces) {
    quads_.push_back(TerrainQuadOf(surface));
  }
  if (!quads_.empty()) bounds_ = quads_.front().bounds;
  for (const TerrainQuad& quad : quads_) {
    const Bounds& other = quad.bounds;
    bounds_.low = {std::min(bounds_.low.x, other.low.x),
                   std::min(bounds_.low.y, other.low.y),
                   std::min(bounds_.low.z, other.low.z)};
    bounds_.high = {std::max(bounds_.high.x, other.high.x),
                    std::max(bounds_.high.y, other.high.y),
                    std::max(bounds_.high.z, other.high.z)};
  }
  const geometry::Vec3 size = bounds_.high - bounds_.low;
  columns_ = static_cast<int>(size.x / kCell_m) + 1;
  rows_ = static_cast<int>(size.y / kCell_m) + 1;
  all_ = MakeGrid(false);
  carrying_ = MakeGrid(true);
}

int Terrain::CellX(double x_m) const {
  return static_cast<int>(std::clamp((x_m - bounds_.low.x) / kCell_m, 0.0,
                                     static_cast<double>(columns_ - 1)));
}

int Terrain::CellY(double y_m) const {
  return static_cast<int>(std::clamp((y_m - bounds_.low.y) / kCell_m, 0.0,
                                     static_cast<double>(rows_ - 1)));
}

std::span<const uint32_t> Terrain::Cell(const Grid& grid, int x, int y) const {
  const size_t cell = static_cast<size_t>(y) * static_cast<size_t>(columns_) +
                      static_cast<size_t>(x);
  return {grid.members.data() + grid.starts[cell],
          grid.members.data() + grid.starts[cell + 1]};
}

Terrain::Grid Terrain::MakeGrid(bool carrying_only) const {
  const auto for_each_cell = [&](const auto& visit) {
    for (uint32_t i = 0; i < quads_.size(); ++i) {
      if (carrying_only && !quads_[i].carries) continue;
      const Bounds& b = quads_[i].bounds;
      for (int y = CellY(b.low.y - kSeam_m); y <= CellY(b.high.y + kSeam_m);
           ++y) {
        for (int x = CellX(b.low.x - kSeam_m); x <= CellX(b.high.x + kSeam_m);
             ++x) {
          visit(static_cast<size_t>(y * columns_ + x), i);
        }
      }
    }
  };
  Grid grid;
  grid.starts.assign(static_cast<size_t>(columns_ * rows_) + 1, 0);
  for_each_cell([&](size_t cell, uint32_t) { ++grid.starts[cell + 1]; });
  for (size_t i = 1; i < grid.starts.size(); ++i) {
    grid.starts[i] += grid.starts[i - 1];
  }
  grid.members.resize(grid.starts.back());
  std::vector<uint32_t> next(grid.starts.begin(), grid.starts.end() - 1);
  for_each_cell(
      [&](size_t cell, uint32_t i) { grid.members[next[cell]++] = i; });
  return grid;
}

std::optional<Ground> Terrain::GroundAt(geometry::Vec2 at, double lowest_m,
                                        double highest_m) const {
  std::optional<Ground> best;
  for (const uint32_t i : Cell(carrying_, CellX(at.x), CellY(at.y))) {
    const TerrainQuad& quad = quads_[i];
    if (quad.bounds.low.z > highest_m || quad.bounds.high.z < lowest_m ||
        !CoversFromAbove(quad, at)) {
      continue;
    }
    const double height_m = HeightAt(quad, at);
    if (height_m > highest_m || height_m < lowest_m) continue;
    if (!best.has_value() || height_m > best->height_m) {
      best = Ground{.height_m = height_m, .kind = quad.kind};
    }
  }
  return best;
}

void Terrain::Near(geometry::Vec2 at, double reach_m,
                   std::vector<uint32_t>& near) const {
  near.clear();
  for (int y = CellY(at.y - reach_m); y <= CellY(at.y + reach_m); ++y) {
    for (int x = CellX(at.x - reach_m); x <= CellX(at.x + reach_m); ++x) {
      for (const uint32_t i : Cell(all_, x, y)) {
        const Bounds& b = quads_[i].bounds;
        if (b.low.x <= at.x + reach_m && b.high.x >= at.x - reach_m &&
            b.low.y <= at.y + reach_m && b.high.y >= at.y - reach_m) {
          near.push_back(i);
        }
      }
    }
  }
  std::ranges::sort(near);
  near.erase(std::unique(near.begin(), near.end()), near.end());
}

}  // namespace treeline::simulator

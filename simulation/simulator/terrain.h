// What never moves in a world, prepared for wheels and bumpers: how high the
// ground is, and what stands near.
#ifndef SIMULATION_SIMULATOR_TERRAIN_H_
#define SIMULATION_SIMULATOR_TERRAIN_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "simulation/simulator/oriented_box.h"
#include "simulation/worlds/world.h"

namespace treeline::simulator {

// A surface in double precision.
struct TerrainQuad {
  QuadCorners corners;
  Bounds bounds;
  // Of unit length, upwards or level.
  geometry::Vec3 normal;
  worlds::SurfaceKind kind = worlds::SurfaceKind::kOther;
  // Flat enough to carry a wheel (less than 45 degrees), whatever it is.
  bool carries = false;
};

TerrainQuad TerrainQuadOf(const worlds::Surface& surface);

struct Ground {
  double height_m = 0;
  worlds::SurfaceKind kind = worlds::SurfaceKind::kOther;
};

// All surfaces, in a grid as seen from above. Panes of glass are as solid as
// the rest. Immutable and thread-safe.
class Terrain {
 public:
  explicit Terrain(const worlds::World& world);

  const std::vector<TerrainQuad>& quads() const { return quads_; }
  // Of all of them.
  const Bounds& bounds() const { return bounds_; }

  // The highest surface that carries, at a place and between two heights: with
  // the wheel's height and a step more for the highest, floors above and
  // below do not matter.
  std::optional<Ground> GroundAt(geometry::Vec2 at, double lowest_m,
                                 double highest_m) const;

  // Replaces `near` with the surfaces that may reach into the square of
  // +- reach_m about `at`, in ascending order.
  void Near(geometry::Vec2 at, double reach_m,
            std::vector<uint32_t>& near) const;

 private:
  // Surfaces by cell, those of cell i at [starts[i], starts[i + 1]).
  struct Grid {
    std::vector<uint32_t> starts;
    std::vector<uint32_t> members;
  };
  Grid MakeGrid(bool carrying_only) const;
  int CellX(double x_m) const;
  int CellY(double y_m) const;
  std::span<const uint32_t> Cell(const Grid& grid, int x, int y) const;

  std::vector<TerrainQuad> quads_;
  Bounds bounds_;
  int columns_ = 1;
  int rows_ = 1;
  Grid all_;
  Grid carrying_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_TERRAIN_H_

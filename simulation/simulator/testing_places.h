// Small worlds for the simulator's tests.
#ifndef SIMULATION_SIMULATOR_TESTING_PLACES_H_
#define SIMULATION_SIMULATOR_TESTING_PLACES_H_

#include <string>
#include <utility>

#include "simulation/worlds/world_builder.h"

namespace treeline::simulator {

// Puts places for tests together: grey all over.
class PlaceBuilder {
 public:
  PlaceBuilder()
      : grey_{.texture = builder_.AddTexture([] {
          return worlds::Canvas(8, 8, {0.5f, 0.5f, 0.5f});
        })} {}

  worlds::WorldBuilder& builder() { return builder_; }
  const worlds::Finish& grey() const { return grey_; }

  PlaceBuilder& Floor(float x0, float y0, float x1, float y1, float z) {
    return Quad(worlds::SurfaceKind::kFloor, {x0, y1, z}, {x1, y1, z},
                {x1, y0, z}, {x0, y0, z});
  }
  // Along x: from height z0 at x0 to z1 at x1.
  PlaceBuilder& Ramp(float x0, float y0, float x1, float y1, float z0,
                     float z1) {
    return Quad(worlds::SurfaceKind::kRamp, {x0, y1, z0}, {x1, y1, z1},
                {x1, y0, z1}, {x0, y0, z0});
  }
  PlaceBuilder& Box(worlds::SurfaceKind kind, worlds::Float3 low,
                    worlds::Float3 high, bool has_bottom = false) {
    builder_.set_kind(kind);
    builder_.AddBox({}, low, high, {.sides = grey_, .has_bottom = has_bottom});
    return *this;
  }
  // Walls of 2.5 m around a rectangle.
  PlaceBuilder& Walls(float x0, float y0, float x1, float y1) {
    const float z = 2.5f;
    Quad(worlds::SurfaceKind::kWall, {x0, y0, z}, {x1, y0, z}, {x1, y0, 0},
         {x0, y0, 0});
    Quad(worlds::SurfaceKind::kWall, {x0, y1, z}, {x1, y1, z}, {x1, y1, 0},
         {x0, y1, 0});
    Quad(worlds::SurfaceKind::kWall, {x0, y0, z}, {x0, y1, z}, {x0, y1, 0},
         {x0, y0, 0});
    return Quad(worlds::SurfaceKind::kWall, {x1, y0, z}, {x1, y1, z},
                {x1, y1, 0}, {x1, y0, 0});
  }
  PlaceBuilder& Quad(worlds::SurfaceKind kind, worlds::Float3 a,
                     worlds::Float3 b, worlds::Float3 c, worlds::Float3 d) {
    builder_.set_kind(kind);
    builder_.AddQuad({}, {a, b, c, d}, grey_);
    return *this;
  }
  // A post of 0.4 x 0.4 x 1.7 m.
  PlaceBuilder& Body(const std::string& name,
                     std::optional<worlds::Motion> motion) {
    builder_.set_kind(worlds::SurfaceKind::kOther);
    builder_.BeginBody();
    builder_.AddBox({}, {-0.2f, -0.2f, 0}, {0.2f, 0.2f, 1.7f},
                    {.sides = grey_});
    builder_.EndBody(name, 0.29f, 1.7f, std::move(motion));
    return *this;
  }
  worlds::World Build() {
    builder_.AddLight({.corner = {1.9f, 1.4f, 2.4f},
                       .edge_u = {0.2f, 0, 0},
                       .edge_v = {0, 0.2f, 0},
                       .radiance = {20, 20, 20}});
    return builder_.Build("place", {20, 20, 3}, {}, 1);
  }

 private:
  worlds::WorldBuilder builder_;
  worlds::Finish grey_;
};

// A hall of 20 x 20 m.
inline PlaceBuilder Hall() {
  PlaceBuilder place;
  place.Floor(0, 0, 20, 20, 0).Walls(0, 0, 20, 20);
  return place;
}

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_TESTING_PLACES_H_

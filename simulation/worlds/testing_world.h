// A small world for tests, with nothing to paint and little to light.
#ifndef SIMULATION_WORLDS_TESTING_WORLD_H_
#define SIMULATION_WORLDS_TESTING_WORLD_H_

#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

// An empty room, 4 x 3 x 2.5 m, grey all over, with a lamp under the ceiling
// and a white box of 1 m on the floor in the corner at the origin.
inline World TestingWorld() {
  constexpr float kX = 4;
  constexpr float kY = 3;
  constexpr float kZ = 2.5f;
  WorldBuilder builder;
  const Finish grey = {.texture = builder.AddTexture([] {
    return Canvas(8, 8, {0.5f, 0.5f, 0.5f});
  })};
  const Finish white = {.texture =
                            builder.AddTexture([] { return Canvas(8, 8); })};
  const Placement origin;
  builder.AddPanel(origin, {kX, 0, kZ}, {-kX, 0, 0}, {0, 0, -kZ}, grey);
  builder.AddPanel(origin, {kX, kY, kZ}, {0, -kY, 0}, {0, 0, -kZ}, grey);
  builder.AddPanel(origin, {0, kY, kZ}, {kX, 0, 0}, {0, 0, -kZ}, grey);
  builder.AddPanel(origin, {0, 0, kZ}, {0, kY, 0}, {0, 0, -kZ}, grey);
  builder.AddPanel(origin, {0, kY, 0}, {kX, 0, 0}, {0, -kY, 0}, grey);
  builder.AddPanel(origin, {0, 0, kZ}, {kX, 0, 0}, {0, kY, 0}, grey);
  builder.AddBox(origin, {0.001f, 0.001f, 0}, {1, 1, 1}, {.sides = white});
  builder.AddLight({.corner = {1.9f, 1.4f, 2.4f},
                    .edge_u = {0.2f, 0, 0},
                    .edge_v = {0, 0.2f, 0},
                    .radiance = {20, 20, 20}});
  return builder.Build(
      "testing", {kX, kY, kZ},
      {.center_x_m = 2.5, .center_y_m = 2, .half_x_m = 0.5, .half_y_m = 0.5},
      1);
}

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_TESTING_WORLD_H_

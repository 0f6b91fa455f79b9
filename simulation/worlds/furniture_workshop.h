// What the makers of furniture share: the world that they build in, the random
// numbers that details are drawn from, and materials. The order of draws
// decides what a world looks like.
#ifndef SIMULATION_WORLDS_FURNITURE_WORKSHOP_H_
#define SIMULATION_WORLDS_FURNITURE_WORKSHOP_H_

#include <cstdint>
#include <functional>

#include "common/base/random.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

struct FurnitureWorkshop {
  FurnitureWorkshop(WorldBuilder& world_builder, uint64_t seed);

  // A seed that has not been used yet.
  uint64_t NextSeed() { return random.NextBits(); }
  float Uniform(float low, float high) {
    return static_cast<float>(random.NextUniform(low, high));
  }
  Finish Wood(Float3 tone);
  Finish Plain(Float3 color);
  // One picture over the whole surface.
  Finish Stretched(std::function<Canvas()> paint, float emission = 0);
  // Four, upright, at the corners of the box from low to high.
  void TableLegs(const Placement& at, Float3 low, Float3 high, float thick_m,
                 const Finish& finish);

  WorldBuilder& builder;
  base::Random random;
  Finish dark_wood;
  Finish light_wood;
  Finish white;
  Finish black;
  Finish metal;
  Finish paper_edge;
  // Textures.
  int spines = 0;
  int leaf = 0;
  // Of the next picture on a wall: see PaintPicture.
  int next_picture = 0;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_FURNITURE_WORKSHOP_H_

// Finishes that a building has everywhere.
#ifndef SIMULATION_WORLDS_BUILDING_TRIM_H_
#define SIMULATION_WORLDS_BUILDING_TRIM_H_

#include <functional>

#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

struct BuildingTrim {
  Finish white;
  Finish metal;
  Finish shine;  // of lamps
};
BuildingTrim MakeBuildingTrim(WorldBuilder& builder);

// A new texture as a finish; tile_m 0: stretched over the whole surface.
Finish PaintedFinish(WorldBuilder& builder, std::function<Canvas()> paint,
                     float tile_m = 0, float emission = 0);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_BUILDING_TRIM_H_

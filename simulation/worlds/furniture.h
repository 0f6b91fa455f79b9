// Pieces of furniture for rooms, by their names.
#ifndef SIMULATION_WORLDS_FURNITURE_H_
#define SIMULATION_WORLDS_FURNITURE_H_

#include <cstdint>

#include "absl/strings/string_view.h"
#include "simulation/worlds/furniture_home.h"
#include "simulation/worlds/furniture_public.h"
#include "simulation/worlds/furniture_things.h"
#include "simulation/worlds/furniture_workshop.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

class FurnitureMaker {
 public:
  FurnitureMaker(WorldBuilder& builder, uint64_t seed)
      : shop_(builder, seed),
        things_(shop_),
        home_(shop_, things_),
        public_(shop_, things_) {}
  // Its parts know each other.
  FurnitureMaker(const FurnitureMaker&) = delete;
  FurnitureMaker& operator=(const FurnitureMaker&) = delete;

  SmallFurnishings& things() { return things_; }
  HomeFurniture& home() { return home_; }

  // Any of those that stand on floors, by its name in snake_case; width_m for
  // those that have one. False if there is none of that name.
  bool ByName(absl::string_view name, const Placement& at, float width_m);

  // A seed that has not been used yet.
  uint64_t NextSeed() { return shop_.NextSeed(); }
  float Uniform(float low, float high) { return shop_.Uniform(low, high); }

 private:
  FurnitureWorkshop shop_;
  SmallFurnishings things_;
  HomeFurniture home_;
  PublicFurniture public_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_FURNITURE_H_

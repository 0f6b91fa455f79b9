// Furniture of homes.
#ifndef SIMULATION_WORLDS_FURNITURE_HOME_H_
#define SIMULATION_WORLDS_FURNITURE_HOME_H_

#include "simulation/worlds/furniture_things.h"
#include "simulation/worlds/furniture_workshop.h"

namespace treeline::worlds {

class HomeFurniture {
 public:
  HomeFurniture(FurnitureWorkshop& shop, SmallFurnishings& things)
      : shop_(shop), things_(things) {}

  // Against a wall, with the back left corner at the placement's origin (see
  // Placement). Lengths along it are in the names' comments.
  void Bookcase(const Placement& at, float width_m);   // 0.3 m deep
  void Desk(const Placement& at);                      // 1.5 x 0.75 m
  void Sideboard(const Placement& at, float width_m);  // 0.45 m deep
  void Wardrobe(const Placement& at);                  // 1.0 x 0.6 m
  void Sofa(const Placement& at);                      // 1.9 x 0.9 m
  // In the middle of a room; the origin is the middle of its footprint.
  void Chair(const Placement& at);
  void CoffeeTable(const Placement& at);  // 1.0 x 0.6 m

 private:
  FurnitureWorkshop& shop_;
  SmallFurnishings& things_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_FURNITURE_HOME_H_

// Lamps, plants, boxes, what hangs on walls, and what stands on furniture. Each
// stands with its back left corner at the placement's origin (see Placement).
#ifndef SIMULATION_WORLDS_FURNITURE_THINGS_H_
#define SIMULATION_WORLDS_FURNITURE_THINGS_H_

#include "simulation/worlds/furniture_workshop.h"

namespace treeline::worlds {

class SmallFurnishings {
 public:
  explicit SmallFurnishings(FurnitureWorkshop& shop) : shop_(shop) {}

  // Against a wall.
  void FloorLamp(const Placement& at);  // 0.4 x 0.4 m
  void BoxStack(const Placement& at);   // 0.7 x 0.5 m
  // 0.4 x 0.4 m; leaves keep within behind_m of the pot's middle towards the
  // wall, and within 0.3 m towards +x.
  void Plant(const Placement& at, float height_m, float behind_m = 0.2f);
  // On a wall: `at` is on the wall's line, z is added.
  void Picture(const Placement& at, float width_m, float height_m);
  void WallShelf(const Placement& at, float width_m);
  void Clock(const Placement& at);
  // On a table top: `at` is the middle of the footprint.
  void SmallThing(const Placement& at);
  // A row of books from x0 to x1 on a board at height z.
  void Books(const Placement& at, float x0, float x1, float depth_m, float z_m,
             float space_m);

 private:
  FurnitureWorkshop& shop_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_FURNITURE_THINGS_H_

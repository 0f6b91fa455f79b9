// Furniture of cafes and offices.
#ifndef SIMULATION_WORLDS_FURNITURE_PUBLIC_H_
#define SIMULATION_WORLDS_FURNITURE_PUBLIC_H_

#include "simulation/worlds/furniture_things.h"
#include "simulation/worlds/furniture_workshop.h"

namespace treeline::worlds {

class PublicFurniture {
 public:
  PublicFurniture(FurnitureWorkshop& shop, SmallFurnishings& things)
      : shop_(shop), things_(things) {}

  // The origin of each is the middle of its footprint.
  void CafeTable(const Placement& at);               // round, 0.7 m
  void Table(const Placement& at, float width_m);    // 0.8 m deep
  void Counter(const Placement& at, float width_m);  // 0.7 m deep
  void Bench(const Placement& at, float width_m);    // 0.4 m deep
  void Stool(const Placement& at);                   // round, 0.35 m
  void Machine(const Placement& at);  // sells drinks; 0.95 x 0.8 m
  void OfficeChair(const Placement& at);
  void Bin(const Placement& at);
  void Rack(const Placement& at, float width_m);   // 0.45 m deep
  void Crate(const Placement& at, float width_m);  // 0.6 m deep
  void Rug(const Placement& at, float width_m);    // 1.4 m deep

 private:
  FurnitureWorkshop& shop_;
  SmallFurnishings& things_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_FURNITURE_PUBLIC_H_

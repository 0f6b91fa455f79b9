// Pieces of furniture for rooms. Each stands with its back left corner at the
// placement's origin (see Placement) and draws its details from `random`.
#ifndef SIMULATION_WORLDS_FURNITURE_H_
#define SIMULATION_WORLDS_FURNITURE_H_

#include "absl/strings/string_view.h"
#include "common/base/random.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

class FurnitureMaker {
 public:
  FurnitureMaker(WorldBuilder& builder, uint64_t seed);

  // Against a wall. Lengths along it are in the names' comments.
  void Bookcase(const Placement& at, float width_m);   // 0.3 m deep
  void Desk(const Placement& at);                      // 1.5 x 0.75 m
  void Sideboard(const Placement& at, float width_m);  // 0.45 m deep
  void Wardrobe(const Placement& at);                  // 1.0 x 0.6 m
  void Sofa(const Placement& at);                      // 1.9 x 0.9 m
  void FloorLamp(const Placement& at);                 // 0.4 x 0.4 m
  // 0.4 x 0.4 m; leaves keep within behind_m of the pot's middle towards the
  // wall, and within 0.3 m towards +x.
  void Plant(const Placement& at, float height_m, float behind_m = 0.2f);
  void BoxStack(const Placement& at);  // 0.7 x 0.5 m
  // In the middle of a room; the origin is the middle of its footprint.
  void Chair(const Placement& at);
  void CoffeeTable(const Placement& at);             // 1.0 x 0.6 m
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
  // On a wall: `at` is on the wall's line, z is added.
  void Picture(const Placement& at, float width_m, float height_m);
  void WallShelf(const Placement& at, float width_m);
  void Clock(const Placement& at);
  // On a table top: `at` is the middle of the footprint.
  void SmallThing(const Placement& at);

  // Any of those that stand on floors, by its name in snake_case; width_m for
  // those that have one. False if there is none of that name.
  bool ByName(absl::string_view name, const Placement& at, float width_m);

  // A seed that has not been used yet.
  uint64_t NextSeed() { return random_.NextBits(); }
  float Uniform(float low, float high) {
    return static_cast<float>(random_.NextUniform(low, high));
  }

 private:
  // A row of books from x0 to x1 on a board at height z.
  void Books(const Placement& at, float x0, float x1, float depth_m, float z_m,
             float space_m);
  void TableLegs(const Placement& at, Float3 low, Float3 high, float thick_m,
                 const Finish& finish);
  Finish Wood(Float3 tone);
  Finish Plain(Float3 color);
  Finish Stretched(std::function<Canvas()> paint, float emission = 0);

  WorldBuilder& builder_;
  base::Random random_;
  Finish dark_wood_;
  Finish light_wood_;
  Finish white_;
  Finish black_;
  Finish metal_;
  Finish paper_edge_;
  int spines_ = 0;
  int leaf_ = 0;
  int next_picture_ = 0;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_FURNITURE_H_

// Puts things into a plan that is being drawn, where there is room for them.
#ifndef SIMULATION_BUILDING_PLAN_FITTER_H_
#define SIMULATION_BUILDING_PLAN_FITTER_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/base/random.h"
#include "simulation/building/building_plan.h"

namespace treeline::building {

// To the centimetre, so that a file holds exactly the same numbers.
double RoundToCm(double value);

// What chance decides of a plan.
class PlanDice {
 public:
  PlanDice(uint64_t seed, uint64_t stream) : random_(seed, stream) {}

  // To the centimetre.
  double Uniform(double low, double high) {
    return RoundToCm(random_.NextUniform(low, high));
  }
  bool Chance(double share) { return random_.NextUnit() < share; }
  const std::string& Pick(const std::vector<std::string>& from) {
    return from[random_.NextBelow(static_cast<uint32_t>(from.size()))];
  }

 private:
  base::Random random_;
};

// Where things are that are drawn as if nothing were mirrored: a building of
// width_m x depth_m is turned over, or not, along x and along y.
struct PlanFrame {
  double width_m = 0;
  double depth_m = 0;
  bool mirrors_x = false;
  bool mirrors_y = false;

  double X(double x) const { return RoundToCm(mirrors_x ? width_m - x : x); }
  double Y(double y) const { return RoundToCm(mirrors_y ? depth_m - y : y); }
  PlanPoint Point(double x, double y) const { return {X(x), Y(y), {}}; }
  PlanArea Area(double x0, double y0, double x1, double y1) const {
    const auto [low_x, high_x] = std::minmax({X(x0), X(x1)});
    const auto [low_y, high_y] = std::minmax({Y(y0), Y(y1)});
    return {low_x, low_y, high_x, high_y};
  }
  double Facing(double facing_deg) const;
  PlanOnWall OnWall(const std::string& room, PlanSide side, double at) const;
};

// The names of looks, as DrawFinishes has added them to a plan; `white` is one
// of the walls'.
struct PlanLooks {
  std::vector<std::string> floors;
  std::vector<std::string> walls;
};
PlanLooks DrawFinishes(int floors, int walls, PlanDice& dice,
                       BuildingPlan& plan);

// All coordinates are those of the frame before it is mirrored. Chance, plan
// and frame must outlive it.
class PlanFitter {
 public:
  PlanFitter(PlanDice& dice, BuildingPlan& plan, const PlanFrame& frame)
      : dice_(dice), plan_(plan), frame_(frame) {}

  // From now on nothing stands in the area.
  void Keep(double x0, double y0, double x1, double y1) {
    taken_.push_back({x0, y0, x1, y1});
  }
  // Nor on either side of this way, along x or y, where the tour passes.
  void KeepLeg(std::array<double, 2> a, std::array<double, 2> b);

  // A named place, with room for a robot.
  void AddPlace(const std::string& name, double x, double y, double facing);

  // Doors and windows; nothing hangs there afterwards.
  void AddDoor(const PlanOnWall& place, double width_m, DoorLeaf leaf);
  void AddWindow(const PlanOnWall& place);

  // A piece of furniture of its kind's usual width, unless it would cover what
  // is taken.
  bool Place(const std::string& kind, double x, double y, double facing,
             int variant = 0);
  // Somewhere along a side of the area, if there is room.
  void PlaceAtWall(const std::string& kind, const PlanArea& area, PlanSide side,
                   int variant = 0);

  // Somewhere on the wall between `low` and `high`, if nothing hangs there.
  void HangPoster(const std::string& room, PlanSide side, double low,
                  double high);

 private:
  // What is on walls already, by wall: from and to.
  struct Hung {
    std::string wall;
    double from = 0;
    double to = 0;
  };
  void Note(const PlanOnWall& place, double width_m);

  PlanDice& dice_;
  BuildingPlan& plan_;
  const PlanFrame& frame_;
  std::vector<PlanArea> taken_;
  std::vector<Hung> hung_;
};

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_PLAN_FITTER_H_

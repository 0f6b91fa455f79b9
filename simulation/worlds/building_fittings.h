// Doors, windows, furniture and people of a building.
#ifndef SIMULATION_WORLDS_BUILDING_FITTINGS_H_
#define SIMULATION_WORLDS_BUILDING_FITTINGS_H_

#include <functional>
#include <map>
#include <string>
#include <tuple>

#include "simulation/building/building_plan.h"
#include "simulation/worlds/building_shell.h"
#include "simulation/worlds/building_trim.h"
#include "simulation/worlds/furniture.h"
#include "simulation/worlds/world.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

// The references must outlive it.
class BuildingFittings {
 public:
  BuildingFittings(const building::BuildingPlan& plan,
                   const WorldOptions& options, const BuildingTrim& trim,
                   WorldBuilder& builder, BuildingShell& shell,
                   FurnitureMaker& furniture)
      : plan_(plan),
        options_(options),
        trim_(trim),
        builder_(builder),
        shell_(shell),
        furniture_(furniture) {}

  // Indices are those in the plan.
  void AddDoor(const building::PlanDoor& door, int index);
  void AddWindow(const building::PlanWindow& window);
  void AddPoster(const building::PlanPoster& poster);
  void AddFurniture(const building::PlanFurniture& piece);
  void AddMover(const building::PlanMover& mover);
  // A body that scenarios put where they like.
  void AddCrate();

  // Of who stands there on the ground.
  Placement StandAt(const building::PlanStand& stand) const;

 private:
  void AddOutsideDoor(const Placement& frame, const building::PlanDoor& door);
  void AddLeaf(const Placement& hinge, const building::PlanDoor& door,
               int index);
  void AddDoorBody(const Placement& hinge, const building::PlanDoor& door,
                   int index);
  // The sides of an opening that goes through a wall of this thickness,
  // seen in the frame of its front face.
  void AddReveal(const Placement& frame, const WallOpening& opening,
                 float thickness_m, const std::string& floor);
  void AddView(const Placement& frame, const building::PlanWindow& window);
  void MakePiece(const building::PlanFurniture& piece);
  void AddPerson();
  void AddCart();
  Motion MotionOf(const building::PlanMover& mover) const;
  Placement OnWall(const building::PlanOnWall& place, double at_m) const;
  Finish Painted(std::function<Canvas()> paint, float tile_m = 0,
                 float emission = 0);

  const building::BuildingPlan& plan_;
  const WorldOptions& options_;
  const BuildingTrim& trim_;
  WorldBuilder& builder_;
  BuildingShell& shell_;
  FurnitureMaker& furniture_;
  // Pieces that are exactly alike: by kind, width in mm, and variant.
  std::map<std::tuple<std::string, int, int>, WorldBuilder::Group> pieces_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_BUILDING_FITTINGS_H_

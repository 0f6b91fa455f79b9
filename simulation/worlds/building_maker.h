// Makes worlds of buildings' plans.
#ifndef SIMULATION_WORLDS_BUILDING_MAKER_H_
#define SIMULATION_WORLDS_BUILDING_MAKER_H_

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/statusor.h"
#include "simulation/building/building_plan.h"
#include "simulation/building/plan_geometry.h"
#include "simulation/worlds/furniture.h"
#include "simulation/worlds/world.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

// INVALID_ARGUMENT for a plan that needs too many surfaces or textures. The
// plan must be one that ParsePlan would give.
absl::StatusOr<World> MakeBuilding(std::string name,
                                   const building::BuildingPlan& plan,
                                   const WorldOptions& options);

// How it is done: one call of Make.
class BuildingMaker {
 public:
  BuildingMaker(const building::BuildingPlan& plan,
                const WorldOptions& options);

  absl::StatusOr<World> Make(std::string name);

 private:
  // A material's picture, and the measures of it.
  struct Material {
    int texture = 0;
    float u_m = 1;
    float v_m = 1;
  };
  const Material& MaterialOf(const std::string& finish);

  // A door or window in a wall's face: from s0 to s1 along x of the face's
  // frame, z0 to z1 above its foot.
  struct Opening {
    float s0 = 0;
    float s1 = 0;
    float z0 = 0;
    float z1 = 0;
  };
  // A wall's surface as seen by who stands before it: x along the wall, which
  // goes from 0 to length_m, y out of it.
  struct Face {
    Placement frame;
    float length_m = 0;
    float height_m = 0;
  };

  // ---- building_shell.cc ----

  // An upright or level rectangle in pieces of at most 6 m, its picture
  // anchored at the frame's origin. As WorldBuilder::AddPanel.
  void AddSheet(const Placement& frame, Float3 top_left, Float3 right,
                Float3 down, const std::string& finish);
  void AddFloor(const building::PlanArea& area, float z,
                const std::string& finish);
  void AddCeiling(const building::PlanArea& area, float z,
                  const std::string& finish);
  void AddFace(const Face& face, std::vector<Opening> openings,
               const std::string& finish, bool has_skirting);
  Face RoomFace(const building::PlanRoom& room, int room_index,
                building::PlanSide side) const;
  Face WallFace(const building::PlanWall& wall, int wall_index,
                bool is_left) const;
  std::vector<Opening> OpeningsOf(const building::WallRef& ref,
                                  const Face& face) const;
  void AddRoom(const building::PlanRoom& room, int index);
  void AddLamps(const building::PlanArea& area, float ceiling_m,
                const building::PlanLamps& lamps);
  void AddPlatform(const building::PlanPlatform& platform);
  void AddRamp(const building::PlanRamp& ramp);
  void AddRampWall(const building::PlanRamp& ramp, bool is_left,
                   float height_m);
  void AddStairs(const building::PlanStairs& stairs);
  void AddWall(const building::PlanWall& wall, int index);
  void AddGlassWall(const building::PlanWall& wall, int index);
  void AddPillar(const building::PlanPillar& pillar);

  // ---- building_fittings.cc ----

  void AddDoor(const building::PlanDoor& door, int index);
  void AddOutsideDoor(const Placement& frame, const building::PlanDoor& door);
  void AddLeaf(const Placement& hinge, const building::PlanDoor& door,
               int index);
  void AddDoorBody(const Placement& hinge, const building::PlanDoor& door,
                   int index);
  // The sides of an opening that goes through a wall of this thickness,
  // seen in the frame of its front face.
  void AddReveal(const Placement& frame, const Opening& opening,
                 float thickness_m, const std::string& floor);
  void AddWindow(const building::PlanWindow& window);
  void AddView(const Placement& frame, const building::PlanWindow& window);
  void AddPoster(const building::PlanPoster& poster);
  void AddFurniture(const building::PlanFurniture& piece);
  void MakePiece(const building::PlanFurniture& piece);
  void AddMover(const building::PlanMover& mover);
  void AddPerson();
  void AddCart();
  void AddCrate();
  Motion MotionOf(const building::PlanMover& mover) const;

  float GroundHeight(const building::PlanPoint& point) const;
  Placement StandAt(const building::PlanStand& stand) const;
  Placement OnWall(const building::PlanOnWall& place, double at_m) const;
  Finish Painted(std::function<Canvas()> paint, float tile_m = 0,
                 float emission = 0);

  const building::BuildingPlan& plan_;
  WorldOptions options_;
  WorldBuilder builder_;
  FurnitureMaker furniture_;
  Finish white_;
  Finish metal_;
  Finish shine_;
  std::map<std::string, Material> materials_;
  // Pieces that are exactly alike: by kind, width in mm, and variant.
  std::map<std::tuple<std::string, int, int>, WorldBuilder::Group> pieces_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_BUILDING_MAKER_H_

// Makes worlds of buildings' plans.
#ifndef COMMON_SYNTHETIC_BUILDING_MAKER_H_
#define COMMON_SYNTHETIC_BUILDING_MAKER_H_

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/statusor.h"
#include "common/synthetic/building/building_plan.h"
#include "common/synthetic/building/plan_geometry.h"
#include "common/synthetic/furniture.h"
#include "common/synthetic/world.h"
#include "common/synthetic/world_builder.h"

namespace treeline {

// INVALID_ARGUMENT for a plan that needs too many surfaces or textures. The
// plan must be one that ParsePlan would give.
absl::StatusOr<World> MakeBuilding(std::string name, const BuildingPlan& plan,
                                   const WorldOptions& options);

// How it is done: one call of Make.
class BuildingMaker {
 public:
  BuildingMaker(const BuildingPlan& plan, const WorldOptions& options);

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
  void AddFloor(const PlanArea& area, float z, const std::string& finish);
  void AddCeiling(const PlanArea& area, float z, const std::string& finish);
  void AddFace(const Face& face, std::vector<Opening> openings,
               const std::string& finish, bool has_skirting);
  Face RoomFace(const PlanRoom& room, int room_index, PlanSide side) const;
  Face WallFace(const PlanWall& wall, int wall_index, bool is_left) const;
  std::vector<Opening> OpeningsOf(const WallRef& ref, const Face& face) const;
  void AddRoom(const PlanRoom& room, int index);
  void AddLamps(const PlanArea& area, float ceiling_m, const PlanLamps& lamps);
  void AddPlatform(const PlanPlatform& platform);
  void AddRamp(const PlanRamp& ramp);
  void AddRampWall(const PlanRamp& ramp, bool is_left, float height_m);
  void AddStairs(const PlanStairs& stairs);
  void AddWall(const PlanWall& wall, int index);
  void AddGlassWall(const PlanWall& wall, int index);
  void AddPillar(const PlanPillar& pillar);

  // ---- building_fittings.cc ----

  void AddDoor(const PlanDoor& door, int index);
  void AddOutsideDoor(const Placement& frame, const PlanDoor& door);
  void AddLeaf(const Placement& hinge, const PlanDoor& door, int index);
  void AddDoorBody(const Placement& hinge, const PlanDoor& door, int index);
  // The sides of an opening that goes through a wall of this thickness,
  // seen in the frame of its front face.
  void AddReveal(const Placement& frame, const Opening& opening,
                 float thickness_m, const std::string& floor);
  void AddWindow(const PlanWindow& window);
  void AddView(const Placement& frame, const PlanWindow& window);
  void AddPoster(const PlanPoster& poster);
  void AddFurniture(const PlanFurniture& piece);
  void MakePiece(const PlanFurniture& piece);
  void AddMover(const PlanMover& mover);
  void AddPerson();
  void AddCart();
  void AddCrate();
  Motion MotionOf(const PlanMover& mover) const;

  float GroundHeight(const PlanPoint& point) const;
  Placement StandAt(const PlanStand& stand) const;
  Placement OnWall(const PlanOnWall& place, double at_m) const;
  Finish Painted(std::function<Canvas()> paint, float tile_m = 0,
                 float emission = 0);

  const BuildingPlan& plan_;
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

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_BUILDING_MAKER_H_

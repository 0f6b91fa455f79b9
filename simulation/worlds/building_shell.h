// Floors, walls, ramps, stairs: what a building is without its contents.
#ifndef SIMULATION_WORLDS_BUILDING_SHELL_H_
#define SIMULATION_WORLDS_BUILDING_SHELL_H_

#include <map>
#include <string>
#include <vector>

#include "simulation/building/building_plan.h"
#include "simulation/building/plan_geometry.h"
#include "simulation/worlds/building_trim.h"
#include "simulation/worlds/placement.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {

// A door or window in a wall's face: from s0 to s1 along x of the face's
// frame, z0 to z1 above its foot.
struct WallOpening {
  float s0 = 0;
  float s1 = 0;
  float z0 = 0;
  float z1 = 0;
};

// The ground's height at a point of the plan; where there is none, the point's
// own.
float GroundHeight(const building::BuildingPlan& plan,
                   const building::PlanPoint& point);

// The references must outlive it.
class BuildingShell {
 public:
  BuildingShell(const building::BuildingPlan& plan, const BuildingTrim& trim,
                WorldBuilder& builder)
      : plan_(plan), trim_(trim), builder_(builder) {}

  // Indices are those in the plan.
  void AddRoom(const building::PlanRoom& room, int index);
  void AddPlatform(const building::PlanPlatform& platform);
  void AddRamp(const building::PlanRamp& ramp);
  void AddStairs(const building::PlanStairs& stairs);
  void AddWall(const building::PlanWall& wall, int index);
  void AddPillar(const building::PlanPillar& pillar);

  // An upright or level rectangle in pieces of at most 6 m, its picture
  // anchored at the frame's origin. As WorldBuilder::AddPanel.
  void AddSheet(const Placement& frame, Float3 top_left, Float3 right,
                Float3 down, const std::string& finish);

 private:
  // A material's picture, and the measures of it.
  struct Material {
    int texture = 0;
    float u_m = 1;
    float v_m = 1;
  };
  // A wall's surface as seen by who stands before it: x along the wall, which
  // goes from 0 to length_m, y out of it.
  struct Face {
    Placement frame;
    float length_m = 0;
    float height_m = 0;
  };

  const Material& MaterialOf(const std::string& finish);
  void AddFloor(const building::PlanArea& area, float z,
                const std::string& finish);
  void AddCeiling(const building::PlanArea& area, float z,
                  const std::string& finish);
  void AddFace(const Face& face, std::vector<WallOpening> openings,
               const std::string& finish, bool has_skirting);
  Face RoomFace(const building::PlanRoom& room, int room_index,
                building::PlanSide side) const;
  Face WallFace(const building::PlanWall& wall, int wall_index,
                bool is_left) const;
  std::vector<WallOpening> OpeningsOf(const building::WallRef& ref,
                                      const Face& face) const;
  void AddLamps(const building::PlanArea& area, float ceiling_m,
                const building::PlanLamps& lamps);
  void AddRampWall(const building::PlanRamp& ramp, bool is_left,
                   float height_m);
  void AddGlassWall(const building::PlanWall& wall, int index);

  const building::BuildingPlan& plan_;
  const BuildingTrim& trim_;
  WorldBuilder& builder_;
  std::map<std::string, Material> materials_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_BUILDING_SHELL_H_

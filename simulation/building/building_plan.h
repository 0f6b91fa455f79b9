// What a building is made of, before it has any surfaces: what a world's file
// says, and what the generator draws. World frame: z up, metres. Angles of
// `facing` are in degrees, counter-clockwise from the x axis, as in the file.
#ifndef SIMULATION_BUILDING_BUILDING_PLAN_H_
#define SIMULATION_BUILDING_BUILDING_PLAN_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "simulation/building/lighting.h"

namespace treeline::building {

// Walls between rooms are this thick; rooms' areas go to their middles.
inline constexpr double kRoomWall_m = 0.12;

// On the ground at (x, y). Where there is ground above ground, z says which.
struct PlanPoint {
  double x_m = 0;
  double y_m = 0;
  std::optional<double> z_m{};

  bool operator==(const PlanPoint&) const = default;
};

struct PlanArea {
  double x0_m = 0;
  double y0_m = 0;
  double x1_m = 0;
  double y1_m = 0;

  bool Contains(double x_m, double y_m) const {
    return x_m >= x0_m && x_m <= x1_m && y_m >= y0_m && y_m <= y1_m;
  }
  bool Overlaps(const PlanArea& other) const {
    return x0_m < other.x1_m && other.x0_m < x1_m && y0_m < other.y1_m &&
           other.y0_m < y1_m;
  }
  bool operator==(const PlanArea&) const = default;
};

// A look that the file gives a name: a material in another colour.
struct PlanFinish {
  std::string name;
  std::string material;  // of Materials()
  std::array<double, 3> color{1, 1, 1};
  bool operator==(const PlanFinish&) const = default;
};

// How many lamps hang in a grid, along x and along y.
struct PlanLamps {
  int along_x = 0;
  int along_y = 0;
  bool operator==(const PlanLamps&) const = default;
};

enum PlanSide { kSouth, kEast, kNorth, kWest };

struct PlanRoom {
  std::string name;
  PlanArea area;
  double base_m = 0;
  double height_m = 3;
  std::string floor = "planks";
  std::array<std::string, 4> walls;  // by PlanSide
  std::string ceiling = "white";
  PlanLamps lamps;
  bool operator==(const PlanRoom&) const = default;
};

// A platform: solid down to base_m, or a slab of thickness_m.
struct PlanPlatform {
  std::string name;
  PlanArea area;
  double height_m = 0;     // of its top
  double base_m = 0;       // where it stands
  double thickness_m = 0;  // 0: solid
  std::string floor = "planks";
  std::string sides = "concrete";
  PlanLamps lamps;  // below a slab
  bool operator==(const PlanPlatform&) const = default;
};

// A ramp along the line from `from` to `to`, which have a height each.
struct PlanRamp {
  std::string name;
  PlanPoint from;
  PlanPoint to;
  double width_m = 1.2;
  double base_m = 0;  // it is solid down to here
  std::string floor = "rubber";
  std::string sides = "concrete";
  // Height of the walls along its edges, seen upwards; 0: open edges.
  double left_wall_m = 0;
  double right_wall_m = 0;

  double Slope() const;  // rise over run
  bool operator==(const PlanRamp&) const = default;
};

struct PlanStairs {
  std::string name;
  PlanPoint from;         // middle of the lowest step's front edge
  double facing_deg = 0;  // upwards
  double width_m = 1.2;
  double rise_m = 0.17;
  double run_m = 0.28;
  int count = 3;
  double base_m = 0;
  std::string finish = "concrete";
  bool operator==(const PlanStairs&) const = default;
};

// A wall that stands within a room, or a pane of glass.
struct PlanWall {
  std::string name;
  PlanPoint from;
  PlanPoint to;
  double height_m = 2.5;
  double thickness_m = 0.1;
  bool is_glass = false;
  std::string finish = "plaster";
  bool operator==(const PlanWall&) const = default;
};

// Part of a wall: "ROOM.SIDE", a wall's name, or its name with .left or
// .right. `at_m`: x on southern and northern sides, y on the others, the way
// from its `from` on a wall.
struct PlanOnWall {
  std::string wall;
  double at_m = 0;
  bool operator==(const PlanOnWall&) const = default;
};

enum class DoorLeaf { kNone, kOpen, kClosed, kMoving };

struct PlanDoor {
  PlanOnWall place;
  double width_m = 0.95;
  double height_m = 2.05;
  DoorLeaf leaf = DoorLeaf::kNone;
  // Of a moving leaf: it opens every period_s, for open_s.
  double period_s = 20;
  double open_s = 8;
  bool operator==(const PlanDoor&) const = default;
};

struct PlanWindow {
  PlanOnWall place;
  double width_m = 1.6;
  double low_m = 0.95;
  double high_m = 2.15;
  bool operator==(const PlanWindow&) const = default;
};

struct PlanPoster {
  PlanOnWall place;
  double middle_m = 1.55;  // height of its middle above the wall's foot
  double width_m = 0.6;
  double height_m = 0.8;
  std::optional<double> moved_to_m{};  // along the same wall
  bool operator==(const PlanPoster&) const = default;
};

struct PlanPillar {
  PlanPoint at;
  double width_m = 0.4;
  bool is_round = false;
  double height_m = 3;
  std::string finish = "concrete";
  bool operator==(const PlanPillar&) const = default;
};

struct PlanStand {
  PlanPoint at;
  double facing_deg = 90;
  bool operator==(const PlanStand&) const = default;
};

struct PlanFurniture {
  std::string kind;  // of FurnitureKinds()
  PlanStand stand;   // the middle of its footprint
  double width_m = 0;
  // Pieces of one kind, width and variant > 0 are exactly alike; 0: like no
  // other.
  int variant = 0;
  std::optional<PlanStand> moved_to{};
  bool operator==(const PlanFurniture&) const = default;
};

enum class MoverKind { kPerson, kCart, kPost };

struct PlanMover {
  std::string name;
  MoverKind kind = MoverKind::kPerson;
  double speed_mps = 0.8;
  // Of a post, which is round.
  double width_m = 0.4;
  double height_m = 1;
  struct Stop {
    PlanPoint at;
    double pause_s = 0;
    // To the next one; 0: the mover's.
    double speed_mps = 0;
    // It is at the next one at once.
    bool jumps = false;
    bool operator==(const Stop&) const = default;
  };
  std::vector<Stop> path;  // closed
  bool operator==(const PlanMover&) const = default;
};

struct PlanPlace {
  std::string name;
  PlanStand stand;
  bool operator==(const PlanPlace&) const = default;
};

struct BuildingPlan {
  std::array<double, 3> size_m{10, 10, 3};
  uint64_t seed = 0;
  // Where nobody asks for another.
  Lighting lighting = Lighting::kDay;
  std::vector<PlanFinish> finishes;
  std::vector<PlanRoom> rooms;
  std::vector<PlanPlatform> platforms;
  std::vector<PlanRamp> ramps;
  std::vector<PlanStairs> stairs;
  std::vector<PlanWall> walls;
  std::vector<PlanDoor> doors;
  std::vector<PlanWindow> windows;
  std::vector<PlanPoster> posters;
  std::vector<PlanPillar> pillars;
  std::vector<PlanFurniture> furniture;
  std::vector<PlanMover> movers;
  std::vector<PlanPlace> places;
  std::vector<PlanPoint> tour;

  bool operator==(const BuildingPlan&) const = default;
};

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_BUILDING_PLAN_H_

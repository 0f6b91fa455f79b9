#include "simulation/building/read_structure.h"

#include <array>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/building/catalogue.h"
#include "simulation/building/plan_geometry.h"
#include "simulation/building/read_values.h"

namespace treeline::building {
namespace {

constexpr double kNear_m = 1e-6;
constexpr double kLeastWall_m = 0.05;

// Names of rooms, platforms, ramps, stairs and walls are one family.
absl::Status CheckNewName(const yaml::YamlNode& node, const BuildingPlan& plan,
                          const std::string& name) {
  const auto is_taken = [&](const auto& list) {
    for (const auto& item : list) {
      if (item.name == name) return true;
    }
    return false;
  };
  if (is_taken(plan.rooms) || is_taken(plan.platforms) ||
      is_taken(plan.ramps) || is_taken(plan.stairs) || is_taken(plan.walls)) {
    return node.Error(absl::StrCat("something is called '", name, "' already"));
  }
  return absl::OkStatus();
}

absl::Status ReadRoomWalls(const yaml::YamlNode& node, const BuildingPlan& plan,
                           PlanRoom& room) {
  room.walls.fill("plaster");
  if (!node.Has("walls")) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode walls, node.Get("walls"));
  if (!walls.IsMap()) {
    TL_ASSIGN_OR_RETURN(const std::string finish, walls.AsText());
    TL_RETURN_IF_ERROR(CheckFinish(walls, finish, plan));
    room.walls.fill(finish);
    return absl::OkStatus();
  }
  TL_RETURN_IF_ERROR(walls.CheckKeys({"south", "east", "north", "west"}));
  size_t side = 0;
  for (const absl::string_view key : {"south", "east", "north", "west"}) {
    TL_ASSIGN_OR_RETURN(room.walls[side++],
                        ReadFinish(walls, key, "plaster", plan));
  }
  return absl::OkStatus();
}

absl::Status CheckHeight(const yaml::YamlNode& node, const BuildingPlan& plan,
                         double top_m) {
  if (top_m <= plan.size_m[2] + kNear_m) return absl::OkStatus();
  return node.Error(absl::StrCat("its top at ", top_m,
                                 " m is above the building, which is ",
                                 plan.size_m[2], " m high"));
}

}  // namespace

absl::Status ReadFinishes(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const std::vector<yaml::YamlNode> items,
      ReadList(file, "finishes", {"name", "material", "color"}));
  if (items.size() > 40) return items[40].Error("more than 40 finishes");
  for (const yaml::YamlNode& item : items) {
    PlanFinish finish;
    TL_ASSIGN_OR_RETURN(finish.name, ReadName(item));
    if (CheckFinish(item, finish.name, plan).ok()) {
      return item.Error(
          absl::StrCat("there is a finish '", finish.name, "' already"));
    }
    TL_ASSIGN_OR_RETURN(finish.material, item.Text("material"));
    TL_RETURN_IF_ERROR(CheckFinish(item, finish.material, BuildingPlan()));
    TL_ASSIGN_OR_RETURN(const std::vector<double> color,
                        item.Numbers("color", 3, 0, 1));
    finish.color = {color[0], color[1], color[2]};
    plan.finishes.push_back(finish);
  }
  return absl::OkStatus();
}

absl::Status ReadRooms(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      ReadList(file, "rooms",
                               {"name", "area", "base", "height", "floor",
                                "walls", "ceiling", "lamps"}));
  for (const yaml::YamlNode& item : items) {
    PlanRoom room;
    TL_ASSIGN_OR_RETURN(room.name, ReadName(item));
    TL_RETURN_IF_ERROR(CheckNewName(item, plan, room.name));
    TL_ASSIGN_OR_RETURN(room.area, ReadArea(item, plan));
    if (room.area.x1_m - room.area.x0_m < 0.8 ||
        room.area.y1_m - room.area.y0_m < 0.8) {
      return item.Error("a room is at least 0.8 m wide");
    }
    TL_ASSIGN_OR_RETURN(room.base_m, item.NumberOr("base", 0, 0, kMaxSize_m));
    TL_ASSIGN_OR_RETURN(
        room.height_m,
        item.NumberOr("height", plan.size_m[2] - room.base_m, 2, 20));
    TL_RETURN_IF_ERROR(CheckHeight(item, plan, room.base_m + room.height_m));
    TL_ASSIGN_OR_RETURN(room.floor, ReadFinish(item, "floor", "planks", plan));
    TL_RETURN_IF_ERROR(ReadRoomWalls(item, plan, room));
    TL_ASSIGN_OR_RETURN(room.ceiling,
                        ReadFinish(item, "ceiling", "white", plan));
    TL_ASSIGN_OR_RETURN(room.lamps, ReadLamps(item));
    for (const PlanRoom& other : plan.rooms) {
      if (room.area.Overlaps(other.area) &&
          room.base_m < other.base_m + other.height_m &&
          other.base_m < room.base_m + room.height_m) {
        return item.Error(
            absl::StrCat("room '", room.name, "' overlaps '", other.name, "'"));
      }
    }
    plan.rooms.push_back(room);
  }
  if (plan.rooms.empty()) return file.Error("there are no rooms");
  return absl::OkStatus();
}

absl::Status ReadPlatforms(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      ReadList(file, "platforms",
                               {"name", "area", "height", "base", "thickness",
                                "floor", "sides", "lamps"}));
  for (const yaml::YamlNode& item : items) {
    PlanPlatform platform;
    TL_ASSIGN_OR_RETURN(platform.name, ReadName(item));
    TL_RETURN_IF_ERROR(CheckNewName(item, plan, platform.name));
    TL_ASSIGN_OR_RETURN(platform.area, ReadArea(item, plan));
    TL_ASSIGN_OR_RETURN(platform.base_m,
                        item.NumberOr("base", 0, 0, kMaxSize_m));
    TL_ASSIGN_OR_RETURN(platform.height_m, item.Number("height", 0.02, 100));
    TL_ASSIGN_OR_RETURN(platform.thickness_m,
                        item.NumberOr("thickness", 0, 0, 2));
    const double rise_m = platform.height_m - platform.base_m;
    if (rise_m < 0.02 || platform.thickness_m > rise_m - 0.02) {
      return item.Error("height must be above base, by more than thickness");
    }
    TL_RETURN_IF_ERROR(CheckHeight(item, plan, platform.height_m));
    TL_ASSIGN_OR_RETURN(platform.floor,
                        ReadFinish(item, "floor", "planks", plan));
    TL_ASSIGN_OR_RETURN(platform.sides,
                        ReadFinish(item, "sides", "concrete", plan));
    TL_ASSIGN_OR_RETURN(platform.lamps, ReadLamps(item));
    if (platform.thickness_m == 0 && platform.lamps != PlanLamps{}) {
      return item.Error("lamps hang below platforms that have a thickness");
    }
    for (const PlanPlatform& other : plan.platforms) {
      if (platform.area.Overlaps(other.area) &&
          std::abs(platform.height_m - other.height_m) < 0.01) {
        return item.Error(absl::StrCat("platform '", platform.name,
                                       "' overlaps '", other.name,
                                       "' at the same height"));
      }
    }
    plan.platforms.push_back(platform);
  }
  return absl::OkStatus();
}

absl::Status ReadRamps(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      ReadList(file, "ramps",
                               {"name", "from", "to", "width", "base", "floor",
                                "sides", "left_wall", "right_wall"}));
  for (const yaml::YamlNode& item : items) {
    PlanRamp ramp;
    TL_ASSIGN_OR_RETURN(ramp.name, ReadName(item));
    TL_RETURN_IF_ERROR(CheckNewName(item, plan, ramp.name));
    TL_ASSIGN_OR_RETURN(ramp.from, ReadPointAt(item, "from", plan));
    TL_ASSIGN_OR_RETURN(ramp.to, ReadPointAt(item, "to", plan));
    if (!ramp.from.z_m || !ramp.to.z_m) {
      return item.Error("a ramp goes from [x, y, z] to [x, y, z]");
    }
    if (*ramp.to.z_m < *ramp.from.z_m + 0.01) {
      return item.Error(absl::StrCat("ramp '", ramp.name,
                                     "' does not rise from its beginning to "
                                     "its end"));
    }
    const double run_m =
        std::hypot(ramp.to.x_m - ramp.from.x_m, ramp.to.y_m - ramp.from.y_m);
    if (run_m < 0.3 || ramp.Slope() > 1) {
      return item.Error(absl::StrCat("ramp '", ramp.name,
                                     "' is steeper than 1:1 or shorter than "
                                     "0.3 m"));
    }
    TL_ASSIGN_OR_RETURN(ramp.width_m, item.NumberOr("width", 1.2, 0.3, 20));
    TL_ASSIGN_OR_RETURN(ramp.base_m,
                        item.NumberOr("base", *ramp.from.z_m, 0, kMaxSize_m));
    if (ramp.base_m > *ramp.from.z_m) {
      return item.Error("base is above the ramp's beginning");
    }
    TL_ASSIGN_OR_RETURN(ramp.floor, ReadFinish(item, "floor", "rubber", plan));
    TL_ASSIGN_OR_RETURN(ramp.sides,
                        ReadFinish(item, "sides", "concrete", plan));
    TL_ASSIGN_OR_RETURN(ramp.left_wall_m, item.NumberOr("left_wall", 0, 0, 3));
    TL_ASSIGN_OR_RETURN(ramp.right_wall_m,
                        item.NumberOr("right_wall", 0, 0, 3));
    plan.ramps.push_back(ramp);
  }
  return absl::OkStatus();
}

absl::Status ReadStairs(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      ReadList(file, "stairs",
                               {"name", "from", "facing", "width", "rise",
                                "run", "count", "finish"}));
  for (const yaml::YamlNode& item : items) {
    PlanStairs stairs;
    TL_ASSIGN_OR_RETURN(stairs.name, ReadName(item));
    TL_RETURN_IF_ERROR(CheckNewName(item, plan, stairs.name));
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode from, item.Get("from"));
    TL_ASSIGN_OR_RETURN(stairs.from, ReadGroundPoint(from, plan));
    stairs.base_m = GroundAt(plan, stairs.from).value_or(0);
    TL_ASSIGN_OR_RETURN(stairs.facing_deg, ReadFacing(item, 90));
    TL_ASSIGN_OR_RETURN(stairs.width_m, item.NumberOr("width", 1.2, 0.3, 20));
    TL_ASSIGN_OR_RETURN(stairs.rise_m, item.NumberOr("rise", 0.17, 0.05, 0.4));
    TL_ASSIGN_OR_RETURN(stairs.run_m, item.NumberOr("run", 0.28, 0.1, 1));
    TL_ASSIGN_OR_RETURN(const int64_t count, item.Integer("count", 1, 60));
    stairs.count = static_cast<int>(count);
    TL_RETURN_IF_ERROR(
        CheckHeight(item, plan, stairs.base_m + stairs.rise_m * stairs.count));
    TL_ASSIGN_OR_RETURN(stairs.finish,
                        ReadFinish(item, "finish", "concrete", plan));
    plan.stairs.push_back(stairs);
  }
  return absl::OkStatus();
}

absl::Status ReadWalls(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const std::vector<yaml::YamlNode> items,
      ReadList(file, "walls",
               {"name", "from", "to", "height", "thickness", "glass", "finish"},
               kMaxPillars));
  for (const yaml::YamlNode& item : items) {
    PlanWall wall;
    TL_ASSIGN_OR_RETURN(wall.name, ReadName(item));
    TL_RETURN_IF_ERROR(CheckNewName(item, plan, wall.name));
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode from, item.Get("from"));
    TL_ASSIGN_OR_RETURN(wall.from, ReadGroundPoint(from, plan));
    wall.from.z_m = GroundAt(plan, wall.from);
    TL_ASSIGN_OR_RETURN(wall.to, ReadPointAt(item, "to", plan));
    if (std::hypot(wall.to.x_m - wall.from.x_m, wall.to.y_m - wall.from.y_m) <
        kLeastWall_m) {
      return item.Error(
          absl::StrCat("a wall is at least ", kLeastWall_m, " m long"));
    }
    TL_ASSIGN_OR_RETURN(
        wall.height_m,
        item.NumberOr("height", plan.size_m[2] - *wall.from.z_m, 0.02, 20));
    TL_RETURN_IF_ERROR(CheckHeight(item, plan, *wall.from.z_m + wall.height_m));
    TL_ASSIGN_OR_RETURN(wall.is_glass, item.BooleanOr("glass", false));
    TL_ASSIGN_OR_RETURN(wall.thickness_m,
                        item.NumberOr("thickness", wall.is_glass ? 0.04 : 0.1,
                                      wall.is_glass ? 0.04 : 0.01, kMaxSize_m));
    TL_ASSIGN_OR_RETURN(wall.finish,
                        ReadFinish(item, "finish", "plaster", plan));
    plan.walls.push_back(wall);
  }
  return absl::OkStatus();
}

absl::Status ReadPillars(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const std::vector<yaml::YamlNode> items,
      ReadList(file, "pillars", {"at", "width", "round", "height", "finish"},
               kMaxPillars));
  for (const yaml::YamlNode& item : items) {
    PlanPillar pillar;
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode at, item.Get("at"));
    TL_ASSIGN_OR_RETURN(pillar.at, ReadGroundPoint(at, plan));
    const double base_m = GroundAt(plan, pillar.at).value_or(0);
    TL_ASSIGN_OR_RETURN(pillar.width_m,
                        item.NumberOr("width", 0.4, 0.02, kMaxSize_m));
    TL_ASSIGN_OR_RETURN(pillar.is_round, item.BooleanOr("round", false));
    TL_ASSIGN_OR_RETURN(
        pillar.height_m,
        item.NumberOr("height", plan.size_m[2] - base_m, 0.02, 100));
    TL_RETURN_IF_ERROR(CheckHeight(item, plan, base_m + pillar.height_m));
    TL_ASSIGN_OR_RETURN(pillar.finish,
                        ReadFinish(item, "finish", "concrete", plan));
    plan.pillars.push_back(pillar);
  }
  return absl::OkStatus();
}

}  // namespace treeline::building

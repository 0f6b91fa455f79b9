#include "simulation/building/plan_file.h"

#include <array>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"
#include "simulation/building/catalogue.h"
#include "simulation/building/read_structure.h"
#include "simulation/building/read_things.h"
#include "simulation/building/read_values.h"

namespace treeline::building {
namespace {

std::string Number(double value) { return absl::StrFormat("%.10g", value); }

std::string List(std::initializer_list<double> values) {
  return absl::StrCat("[",
                      absl::StrJoin(values, ", ",
                                    [](std::string* out, double value) {
                                      out->append(Number(value));
                                    }),
                      "]");
}

std::string Text(const PlanPoint& p) {
  return p.z_m ? List({p.x_m, p.y_m, *p.z_m}) : List({p.x_m, p.y_m});
}

std::string Text(const PlanArea& a) {
  return List({a.x0_m, a.y0_m, a.x1_m, a.y1_m});
}

std::string Text(const PlanLamps& lamps) {
  return absl::StrCat("[", lamps.along_x, ", ", lamps.along_y, "]");
}

// One map on one line, in a list.
class Item {
 public:
  Item& Add(absl::string_view key, absl::string_view value) {
    absl::StrAppend(&text_, text_.empty() ? "" : ", ", key, ": ", value);
    return *this;
  }
  Item& Add(absl::string_view key, double value) {
    return Add(key, Number(value));
  }
  Item& Stand(const PlanStand& stand) {
    return Add("at", Text(stand.at)).Add("facing", stand.facing_deg);
  }
  Item& On(const PlanOnWall& place) {
    return Add("wall", place.wall).Add("at", place.at_m);
  }
  std::string Braced() const { return absl::StrCat("{", text_, "}"); }

 private:
  std::string text_;
};

template <typename Things, typename Write>
void Section(std::string& out, absl::string_view key, const Things& things,
             Write write) {
  if (things.empty()) return;
  absl::StrAppend(&out, key, ":\n");
  for (const auto& thing : things) {
    absl::StrAppend(&out, "  - ", write(thing).Braced(), "\n");
  }
}

Item RoomItem(const PlanRoom& room) {
  Item walls;
  walls.Add("south", room.walls[kSouth])
      .Add("east", room.walls[kEast])
      .Add("north", room.walls[kNorth])
      .Add("west", room.walls[kWest]);
  return Item()
      .Add("name", room.name)
      .Add("area", Text(room.area))
      .Add("base", room.base_m)
      .Add("height", room.height_m)
      .Add("floor", room.floor)
      .Add("walls", walls.Braced())
      .Add("ceiling", room.ceiling)
      .Add("lamps", Text(room.lamps));
}

Item PlatformItem(const PlanPlatform& platform) {
  return Item()
      .Add("name", platform.name)
      .Add("area", Text(platform.area))
      .Add("height", platform.height_m)
      .Add("base", platform.base_m)
      .Add("thickness", platform.thickness_m)
      .Add("floor", platform.floor)
      .Add("sides", platform.sides)
      .Add("lamps", Text(platform.lamps));
}

Item RampItem(const PlanRamp& ramp) {
  return Item()
      .Add("name", ramp.name)
      .Add("from", Text(ramp.from))
      .Add("to", Text(ramp.to))
      .Add("width", ramp.width_m)
      .Add("base", ramp.base_m)
      .Add("floor", ramp.floor)
      .Add("sides", ramp.sides)
      .Add("left_wall", ramp.left_wall_m)
      .Add("right_wall", ramp.right_wall_m);
}

Item DoorItem(const PlanDoor& door) {
  constexpr absl::string_view kLeaves[] = {"none", "open", "closed", "moving"};
  return Item()
      .On(door.place)
      .Add("width", door.width_m)
      .Add("height", door.height_m)
      .Add("leaf", kLeaves[static_cast<size_t>(door.leaf)])
      .Add("period", door.period_s)
      .Add("open_for", door.open_s);
}

Item FurnitureItem(const PlanFurniture& piece, bool has_widths) {
  Item item;
  item.Add("kind", piece.kind).Stand(piece.stand);
  if (has_widths) item.Add("width", piece.width_m);
  item.Add("variant", piece.variant);
  if (piece.moved_to) {
    item.Add("moved_to", Item().Stand(*piece.moved_to).Braced());
  }
  return item;
}

Item MoverItem(const PlanMover& mover) {
  std::vector<std::string> path;
  for (const PlanMover::Stop& stop : mover.path) {
    Item item;
    item.Add("at", Text(stop.at)).Add("pause", stop.pause_s);
    if (stop.speed_mps > 0) item.Add("speed", stop.speed_mps);
    if (stop.jumps) item.Add("jump", "true");
    path.push_back(item.Braced());
  }
  constexpr absl::string_view kKinds[] = {"person", "cart", "post"};
  Item item;
  item.Add("name", mover.name)
      .Add("kind", kKinds[static_cast<size_t>(mover.kind)])
      .Add("speed", mover.speed_mps);
  if (mover.kind == MoverKind::kPost) {
    item.Add("width", mover.width_m).Add("height", mover.height_m);
  }
  return item.Add("path", absl::StrCat("[", absl::StrJoin(path, ", "), "]"));
}

void WriteStructure(const BuildingPlan& plan, std::string& out) {
  Section(out, "finishes", plan.finishes, [](const PlanFinish& finish) {
    return Item()
        .Add("name", finish.name)
        .Add("material", finish.material)
        .Add("color",
             List({finish.color[0], finish.color[1], finish.color[2]}));
  });
  Section(out, "rooms", plan.rooms, RoomItem);
  Section(out, "platforms", plan.platforms, PlatformItem);
  Section(out, "ramps", plan.ramps, RampItem);
  Section(out, "stairs", plan.stairs, [](const PlanStairs& stairs) {
    return Item()
        .Add("name", stairs.name)
        .Add("from", Text(stairs.from))
        .Add("facing", stairs.facing_deg)
        .Add("width", stairs.width_m)
        .Add("rise", stairs.rise_m)
        .Add("run", stairs.run_m)
        .Add("count", stairs.count)
        .Add("finish", stairs.finish);
  });
  Section(out, "walls", plan.walls, [](const PlanWall& wall) {
    return Item()
        .Add("name", wall.name)
        .Add("from", Text(wall.from))
        .Add("to", Text(wall.to))
        .Add("height", wall.height_m)
        .Add("thickness", wall.thickness_m)
        .Add("glass", wall.is_glass ? "true" : "false")
        .Add("finish", wall.finish);
  });
  Section(out, "pillars", plan.pillars, [](const PlanPillar& pillar) {
    return Item()
        .Add("at", Text(pillar.at))
        .Add("width", pillar.width_m)
        .Add("round", pillar.is_round ? "true" : "false")
        .Add("height", pillar.height_m)
        .Add("finish", pillar.finish);
  });
}

void WriteFittings(const BuildingPlan& plan, std::string& out) {
  Section(out, "doors", plan.doors, DoorItem);
  Section(out, "windows", plan.windows, [](const PlanWindow& window) {
    return Item()
        .On(window.place)
        .Add("width", window.width_m)
        .Add("low", window.low_m)
        .Add("high", window.high_m);
  });
  Section(out, "posters", plan.posters, [](const PlanPoster& poster) {
    Item item;
    item.On(poster.place)
        .Add("middle", poster.middle_m)
        .Add("width", poster.width_m)
        .Add("height", poster.height_m);
    if (poster.moved_to_m) item.Add("moved_to", *poster.moved_to_m);
    return item;
  });
}

}  // namespace

absl::StatusOr<BuildingPlan> ParsePlan(absl::string_view text,
                                       absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode file,
                      yaml::YamlNode::Parse(text, name));
  TL_RETURN_IF_ERROR(file.CheckKeys(
      {"size", "seed", "lighting", "finishes", "rooms", "platforms", "ramps",
       "stairs", "walls", "pillars", "doors", "windows", "posters", "furniture",
       "movers", "places", "tour"}));
  BuildingPlan plan;
  TL_ASSIGN_OR_RETURN(const std::vector<double> size,
                      file.Numbers("size", 3, 2, kMaxSize_m));
  plan.size_m = {size[0], size[1], size[2]};
  TL_ASSIGN_OR_RETURN(const int64_t seed,
                      file.IntegerOr("seed", 0, 0, int64_t{1} << 53));
  plan.seed = static_cast<uint64_t>(seed);
  if (file.Has("lighting")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode lighting, file.Get("lighting"));
    TL_ASSIGN_OR_RETURN(plan.lighting, ReadLighting(lighting));
  }
  // Later ones stand on, and hang on, earlier ones.
  for (const auto& read :
       {ReadFinishes, ReadRooms, ReadPlatforms, ReadRamps, ReadStairs,
        ReadWalls, ReadPillars, ReadDoors, ReadWindows, ReadPosters,
        ReadFurniture, ReadMovers, ReadPlaces, ReadTour}) {
    TL_RETURN_IF_ERROR(read(file, plan));
  }
  return plan;
}

std::string PlanText(const BuildingPlan& plan) {
  std::string out;
  absl::StrAppend(
      &out, "size: ", List({plan.size_m[0], plan.size_m[1], plan.size_m[2]}),
      "\nseed: ", plan.seed, "\nlighting: ", LightingName(plan.lighting), "\n");
  WriteStructure(plan, out);
  WriteFittings(plan, out);
  Section(out, "furniture", plan.furniture, [](const PlanFurniture& piece) {
    const FurnitureKind* kind = FindFurniture(piece.kind);
    return FurnitureItem(piece, kind != nullptr && kind->max_width_m > 0);
  });
  Section(out, "movers", plan.movers, MoverItem);
  Section(out, "places", plan.places, [](const PlanPlace& place) {
    return Item().Add("name", place.name).Stand(place.stand);
  });
  if (!plan.tour.empty()) {
    out.append("tour:\n");
    for (const PlanPoint& corner : plan.tour) {
      absl::StrAppend(&out, "  - ", Text(corner), "\n");
    }
  }
  return out;
}

}  // namespace treeline::building

#include "simulation/worlds/building_shell.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/random.h"
#include "simulation/worlds/paint_building.h"
#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {
namespace {

// Longer surfaces are made of several, for the light map's sake.
constexpr float kSheet_m = 6;
constexpr float kSkirting_m = 0.07f;
constexpr float kSkirtingThick_m = 0.012f;
constexpr float kHalfWall_m = static_cast<float>(building::kRoomWall_m / 2);
constexpr float kLamp_m = 0.6f;

float F(double value) { return static_cast<float>(value); }

Float3 ColorOf(const std::string& material, uint64_t seed) {
  base::Random random(seed, 0xc0);
  const auto uniform = [&](float low, float high) {
    return F(random.NextUniform(low, high));
  };
  if (material == "planks" || material == "wood") {
    const float warm = uniform(0.8f, 1.15f);
    return {0.66f * warm, 0.47f * warm, uniform(0.27f, 0.34f)};
  }
  if (material == "brick") return {0.66f, uniform(0.36f, 0.46f), 0.33f};
  if (material == "rubber") return Hsv({uniform(0, 1), 0.25f, 0.38f});
  if (material == "carpet") {
    return Hsv({uniform(0.5f, 0.7f), uniform(0.1f, 0.35f), 0.5f});
  }
  if (material == "tiles") return {0.78f, 0.74f, uniform(0.62f, 0.72f)};
  if (material == "concrete") return {0.58f, 0.58f, 0.57f};
  if (material == "white") return {0.92f, 0.915f, 0.90f};
  return Hsv({uniform(0, 1), uniform(0.08f, 0.28f), uniform(0.75f, 0.88f)});
}

Canvas Paint(const std::string& material, Float3 color, uint64_t seed) {
  if (material == "plaster") return PaintPlasterWall(color, seed);
  if (material == "wallpaper") return PaintPaperWall(color, seed);
  if (material == "brick") return PaintBrickWall(color, seed);
  if (material == "concrete") return PaintConcreteWall(color, seed);
  if (material == "noise") return PaintBlots(color, seed);
  if (material == "planks") return PaintPlankFloor(color, seed);
  if (material == "tiles") return PaintTileFloor(color, seed);
  if (material == "carpet") return PaintCarpetFloor(color, seed);
  if (material == "rubber") return PaintRubberFloor(color, seed);
  if (material == "wood") return PaintWood(color, seed);
  if (material == "white") return Canvas(4, 4, color);
  return PaintPlain(color, 0.1f, seed);
}

bool IsWallMaterial(const std::string& material) {
  return material == "plaster" || material == "wallpaper" ||
         material == "brick" || material == "concrete" || material == "noise";
}

}  // namespace

float GroundHeight(const building::BuildingPlan& plan,
                   const building::PlanPoint& point) {
  return F(building::GroundAt(plan, point).value_or(point.z_m.value_or(0)));
}

const BuildingShell::Material& BuildingShell::MaterialOf(
    const std::string& finish) {
  const auto known = materials_.find(finish);
  if (known != materials_.end()) return known->second;
  uint64_t seed = plan_.seed;
  for (const char c : finish) {
    seed = base::MixBits(seed + static_cast<unsigned char>(c) + 1);
  }
  std::string material = finish;
  Float3 color = ColorOf(material, seed);
  for (const building::PlanFinish& own : plan_.finishes) {
    if (own.name != finish) continue;
    material = own.material;
    color = {F(own.color[0]), F(own.color[1]), F(own.color[2])};
  }
  Material made;
  made.texture =
      builder_.AddTexture([=] { return Paint(material, color, seed); });
  if (IsWallMaterial(material)) {
    made.u_m = 5;
    made.v_m = 2.5f;
  } else if (material == "planks" || material == "tiles" ||
             material == "carpet") {
    made.u_m = made.v_m = 5;
  } else if (material == "wood") {
    made.u_m = made.v_m = 0.8f;
  }
  return materials_.emplace(finish, made).first->second;
}

void BuildingShell::AddSheet(const Placement& frame, Float3 top_left,
                             Float3 right, Float3 down,
                             const std::string& finish) {
  const Material& material = MaterialOf(finish);
  const float width = Norm(right);
  const float height = Norm(down);
  const int columns =
      std::max(1, static_cast<int>(std::ceil(width / kSheet_m)));
  const int rows = std::max(1, static_cast<int>(std::ceil(height / kSheet_m)));
  // Where the corner is in the picture: that of the frame's origin is (0, 0).
  const float u0 = Dot(top_left, (1 / width) * right) / material.u_m;
  const float v0 = Dot(top_left, (1 / height) * down) / material.v_m;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const float s0 = F(column) / F(columns);
      const float s1 = F(column + 1) / F(columns);
      const float t0 = F(row) / F(rows);
      const float t1 = F(row + 1) / F(rows);
      builder_.AddPanel(frame, top_left + s0 * right + t0 * down,
                        (s1 - s0) * right, (t1 - t0) * down,
                        {.texture = material.texture,
                         .u0 = u0 + s0 * width / material.u_m,
                         .v0 = v0 + t0 * height / material.v_m,
                         .u1 = u0 + s1 * width / material.u_m,
                         .v1 = v0 + t1 * height / material.v_m});
    }
  }
}

void BuildingShell::AddFloor(const building::PlanArea& area, float z,
                             const std::string& finish) {
  const float w = F(area.x1_m - area.x0_m);
  const float d = F(area.y1_m - area.y0_m);
  AddSheet({}, {F(area.x0_m), F(area.y1_m), z}, {w, 0, 0}, {0, -d, 0}, finish);
}

void BuildingShell::AddCeiling(const building::PlanArea& area, float z,
                               const std::string& finish) {
  const float w = F(area.x1_m - area.x0_m);
  const float d = F(area.y1_m - area.y0_m);
  AddSheet({}, {F(area.x0_m), F(area.y0_m), z}, {w, 0, 0}, {0, d, 0}, finish);
}

void BuildingShell::AddFace(const Face& face, std::vector<WallOpening> openings,
                            const std::string& finish, bool has_skirting) {
  std::sort(
      openings.begin(), openings.end(),
      [](const WallOpening& a, const WallOpening& b) { return a.s0 < b.s0; });
  const auto part = [&](float s0, float s1, float z0, float z1) {
    if (s1 - s0 < 0.001f || z1 - z0 < 0.001f) return;
    builder_.set_kind(SurfaceKind::kWall);
    AddSheet(face.frame, {s1, 0, z1}, {s0 - s1, 0, 0}, {0, 0, z0 - z1}, finish);
    if (!has_skirting || z0 > 0 || z1 < 3 * kSkirting_m) return;
    builder_.set_kind(SurfaceKind::kOther);
    builder_.AddBox(face.frame, {s0, 0, 0}, {s1, kSkirtingThick_m, kSkirting_m},
                    {.sides = trim_.white});
  };
  float s = 0;
  for (const WallOpening& opening : openings) {
    part(s, opening.s0, 0, face.height_m);
    part(opening.s0, opening.s1, opening.z1, face.height_m);
    part(opening.s0, opening.s1, 0, opening.z0);
    s = opening.s1;
  }
  part(s, face.length_m, 0, face.height_m);
}

BuildingShell::Face BuildingShell::RoomFace(const building::PlanRoom& room,
                                            int room_index,
                                            building::PlanSide side) const {
  building::WallRef ref;
  ref.room = room_index;
  ref.side = side;
  const bool is_along_x = side == building::kSouth || side == building::kNorth;
  const double low = is_along_x ? room.area.x0_m : room.area.y0_m;
  const double high = is_along_x ? room.area.x1_m : room.area.y1_m;
  // The frame's x goes up on southern and eastern sides, down on the others.
  const bool is_rising = side == building::kSouth || side == building::kEast;
  const building::WallFrame at = building::FrameOnWall(
      plan_, ref, is_rising ? low + kHalfWall_m : high - kHalfWall_m);
  return {.frame = {{F(at.x_m), F(at.y_m), F(room.base_m)}, F(at.yaw_rad)},
          .length_m = F(high - low) - 2 * kHalfWall_m,
          .height_m = F(room.height_m)};
}

BuildingShell::Face BuildingShell::WallFace(const building::PlanWall& wall,
                                            int wall_index,
                                            bool is_left) const {
  building::WallRef ref;
  ref.wall = wall_index;
  ref.is_left = is_left;
  const double length =
      std::hypot(wall.to.x_m - wall.from.x_m, wall.to.y_m - wall.from.y_m);
  const building::WallFrame at =
      building::FrameOnWall(plan_, ref, is_left ? 0 : length);
  return {.frame = {{F(at.x_m), F(at.y_m), F(wall.from.z_m.value_or(0))},
                    F(at.yaw_rad)},
          .length_m = F(length),
          .height_m = F(wall.height_m)};
}

std::vector<WallOpening> BuildingShell::OpeningsOf(const building::WallRef& ref,
                                                   const Face& face) const {
  std::vector<WallOpening> openings;
  const auto add = [&](const building::PlanOnWall& place, double width_m,
                       double low_m, double high_m) {
    const auto own = building::FindWall(plan_, place.wall);
    if (!own) return;
    const double at0 = place.at_m - width_m / 2;
    const double at1 = place.at_m + width_m / 2;
    const auto behind = building::WallBehind(plan_, *own, at0, at1);
    // Openings to the outside are painted on, not cut.
    if (own->room >= 0 && !behind) return;
    if (!own->IsSameFace(ref) && !(behind && behind->IsSameFace(ref))) return;
    const building::WallFrame at =
        building::FrameOnWall(plan_, ref, place.at_m);
    const Float3 way = Float3{F(at.x_m), F(at.y_m), 0} - face.frame.origin;
    const float middle = Dot(way, face.frame.Direction({1, 0, 0}));
    openings.push_back({middle - F(width_m / 2), middle + F(width_m / 2),
                        F(low_m), F(high_m)});
  };
  for (const building::PlanDoor& door : plan_.doors) {
    add(door.place, door.width_m, 0, door.height_m);
  }
  for (const building::PlanWindow& window : plan_.windows) {
    add(window.place, window.width_m, window.low_m, window.high_m);
  }
  return openings;
}

void BuildingShell::AddLamps(const building::PlanArea& area, float ceiling_m,
                             const building::PlanLamps& lamps) {
  const int count = lamps.along_x * lamps.along_y;
  if (count == 0) return;
  const float w = F(area.x1_m - area.x0_m);
  const float d = F(area.y1_m - area.y0_m);
  // The same brightness whatever the number of lamps.
  const float radiance =
      std::min(24.0f, 0.42f * w * d / F(count) / (kLamp_m * kLamp_m));
  for (int i = 0; i < lamps.along_x; ++i) {
    for (int j = 0; j < lamps.along_y; ++j) {
      const Float3 corner = {
          F(area.x0_m) + w * (F(i) + 0.5f) / F(lamps.along_x) - kLamp_m / 2,
          F(area.y0_m) + d * (F(j) + 0.5f) / F(lamps.along_y) - kLamp_m / 2,
          ceiling_m - 0.06f};
      const Placement at = {corner, 0};
      builder_.set_kind(SurfaceKind::kCeiling);
      builder_.BeginLamp();
      builder_.AddBox(at, {-0.02f, -0.02f, 0},
                      {kLamp_m + 0.02f, kLamp_m + 0.02f, 0.059f},
                      {.sides = trim_.metal});
      builder_.AddPanel(at, {-0.02f, -0.02f, 0}, {kLamp_m + 0.04f, 0, 0},
                        {0, kLamp_m + 0.04f, 0}, trim_.shine);
      builder_.AddLight({.corner = corner - Float3{0, 0, 0.01f},
                         .edge_u = {kLamp_m, 0, 0},
                         .edge_v = {0, kLamp_m, 0},
                         .radiance = radiance * Float3{1, 0.95f, 0.86f}});
      builder_.EndLamp();
    }
  }
}

void BuildingShell::AddRoom(const building::PlanRoom& room, int index) {
  const float base = F(room.base_m);
  const building::PlanArea inside = {
      room.area.x0_m + kHalfWall_m, room.area.y0_m + kHalfWall_m,
      room.area.x1_m - kHalfWall_m, room.area.y1_m - kHalfWall_m};
  builder_.set_kind(SurfaceKind::kFloor);
  AddFloor(inside, base, room.floor);
  builder_.set_kind(SurfaceKind::kCeiling);
  AddCeiling(inside, base + F(room.height_m), room.ceiling);
  for (const building::PlanSide side :
       {building::kSouth, building::kEast, building::kNorth, building::kWest}) {
    const Face face = RoomFace(room, index, side);
    building::WallRef ref;
    ref.room = index;
    ref.side = side;
    AddFace(face, OpeningsOf(ref, face), room.walls[side], true);
  }
  AddLamps(inside, base + F(room.height_m), room.lamps);
}

void BuildingShell::AddPlatform(const building::PlanPlatform& platform) {
  const building::PlanArea& area = platform.area;
  const float top = F(platform.height_m);
  const float bottom =
      F(platform.thickness_m > 0 ? platform.height_m - platform.thickness_m
                                 : platform.base_m);
  builder_.set_kind(SurfaceKind::kFloor);
  AddFloor(area, top, platform.floor);
  if (platform.thickness_m > 0) {
    builder_.set_kind(SurfaceKind::kCeiling);
    AddCeiling(area, bottom, "white");
    AddLamps(area, bottom, platform.lamps);
  }
  builder_.set_kind(SurfaceKind::kWall);
  const float w = F(area.x1_m - area.x0_m);
  const float d = F(area.y1_m - area.y0_m);
  const float x0 = F(area.x0_m);
  const float y0 = F(area.y0_m);
  const Float3 down = {0, 0, bottom - top};
  AddSheet({}, {x0, y0, top}, {w, 0, 0}, down, platform.sides);
  AddSheet({}, {x0 + w, y0, top}, {0, d, 0}, down, platform.sides);
  AddSheet({}, {x0 + w, y0 + d, top}, {-w, 0, 0}, down, platform.sides);
  AddSheet({}, {x0, y0 + d, top}, {0, -d, 0}, down, platform.sides);
}

void BuildingShell::AddRamp(const building::PlanRamp& ramp) {
  const float dx = F(ramp.to.x_m - ramp.from.x_m);
  const float dy = F(ramp.to.y_m - ramp.from.y_m);
  const float run = std::hypot(dx, dy);
  const float low = F(ramp.from.z_m.value_or(0));
  const float high = F(ramp.to.z_m.value_or(0));
  const float base = F(ramp.base_m);
  const float half = F(ramp.width_m / 2);
  // x upwards, y to the left.
  const Placement frame = {{F(ramp.from.x_m), F(ramp.from.y_m), 0},
                           std::atan2(dy, dx)};
  builder_.set_kind(SurfaceKind::kRamp);
  AddSheet(frame, {0, half, low}, {run, 0, high - low}, {0, -2 * half, 0},
           ramp.floor);
  builder_.set_kind(SurfaceKind::kWall);
  const Material& sides = MaterialOf(ramp.sides);
  const Finish finish = {.texture = sides.texture,
                         .u1 = run / sides.u_m,
                         .v1 = (high - base) / sides.v_m};
  // Corners begin at the high end: at the low one two may be the same.
  builder_.AddQuad(frame,
                   {Float3{run, half, high},
                    {0, half, low},
                    {0, half, base},
                    {run, half, base}},
                   finish);
  builder_.AddQuad(frame,
                   {Float3{run, -half, base},
                    {0, -half, base},
                    {0, -half, low},
                    {run, -half, high}},
                   finish);
  AddSheet(frame, {run, -half, high}, {0, 2 * half, 0}, {0, 0, base - high},
           ramp.sides);
  if (low - base > 0.001f) {
    AddSheet(frame, {0, half, low}, {0, -2 * half, 0}, {0, 0, base - low},
             ramp.sides);
  }
  if (ramp.left_wall_m > 0) AddRampWall(ramp, true, F(ramp.left_wall_m));
  if (ramp.right_wall_m > 0) AddRampWall(ramp, false, F(ramp.right_wall_m));
}

void BuildingShell::AddRampWall(const building::PlanRamp& ramp, bool is_left,
                                float height_m) {
  constexpr float kThick = 0.06f;
  const float dx = F(ramp.to.x_m - ramp.from.x_m);
  const float dy = F(ramp.to.y_m - ramp.from.y_m);
  const float run = std::hypot(dx, dy);
  const float low = F(ramp.from.z_m.value_or(0));
  const float high = F(ramp.to.z_m.value_or(0));
  const float base = F(ramp.base_m);
  const Placement frame = {{F(ramp.from.x_m), F(ramp.from.y_m), 0},
                           std::atan2(dy, dx)};
  // Just outside of the ramp's width.
  const float edge = F(ramp.width_m / 2);
  const float right = is_left ? edge : -edge - kThick;
  const float left = right + kThick;
  const Material& sides = MaterialOf(ramp.sides);
  const Finish finish = {.texture = sides.texture,
                         .u1 = run / sides.u_m,
                         .v1 = (high + height_m - base) / sides.v_m};
  const float top0 = low + height_m;
  const float top1 = high + height_m;
  builder_.AddQuad(frame,
                   {Float3{run, left, top1},
                    {0, left, top0},
                    {0, left, base},
                    {run, left, base}},
                   finish);
  builder_.AddQuad(frame,
                   {Float3{0, right, top0},
                    {run, right, top1},
                    {run, right, base},
                    {0, right, base}},
                   finish);
  builder_.AddQuad(frame,
                   {Float3{0, left, top0},
                    {run, left, top1},
                    {run, right, top1},
                    {0, right, top0}},
                   trim_.white);
  AddSheet(frame, {0, left, top0}, {0, -kThick, 0}, {0, 0, base - top0},
           ramp.sides);
  AddSheet(frame, {run, right, top1}, {0, kThick, 0}, {0, 0, base - top1},
           ramp.sides);
}

void BuildingShell::AddStairs(const building::PlanStairs& stairs) {
  const Placement frame = {
      {F(stairs.from.x_m), F(stairs.from.y_m), F(stairs.base_m)},
      F(stairs.facing_deg * std::numbers::pi / 180)};
  const float half = F(stairs.width_m / 2);
  const float run = F(stairs.run_m);
  const float rise = F(stairs.rise_m);
  builder_.set_kind(SurfaceKind::kStair);
  for (int i = 0; i < stairs.count; ++i) {
    const float x = run * F(i);
    const float z = rise * F(i + 1);
    AddSheet(frame, {x, half, z}, {0, -2 * half, 0}, {0, 0, -rise},
             stairs.finish);
    AddSheet(frame, {x, half, z}, {run, 0, 0}, {0, -2 * half, 0},
             stairs.finish);
    AddSheet(frame, {x + run, half, z}, {-run, 0, 0}, {0, 0, -z},
             stairs.finish);
    AddSheet(frame, {x, -half, z}, {run, 0, 0}, {0, 0, -z}, stairs.finish);
    // The edge that shows where to step.
    const float lift = z + 0.001f;
    builder_.AddPanel(frame, {x + 0.005f, half, lift}, {0.04f, 0, 0},
                      {0, -2 * half, 0}, trim_.metal);
  }
  const float end = run * F(stairs.count);
  AddSheet(frame, {end, -half, rise * F(stairs.count)}, {0, 2 * half, 0},
           {0, 0, -rise * F(stairs.count)}, stairs.finish);
}

void BuildingShell::AddWall(const building::PlanWall& wall, int index) {
  if (wall.is_glass) return AddGlassWall(wall, index);
  building::WallRef ref;
  ref.wall = index;
  const float thick = F(wall.thickness_m);
  std::vector<WallOpening> openings;
  Face left;
  for (const bool is_left : {false, true}) {
    const Face face = WallFace(wall, index, is_left);
    ref.is_left = is_left;
    openings = OpeningsOf(ref, face);
    AddFace(face, openings, wall.finish, wall.height_m > 1);
    left = face;
  }
  // Ends and top, in the left face's frame: y is out of the wall.
  builder_.set_kind(SurfaceKind::kWall);
  const float length = left.length_m;
  const float height = left.height_m;
  AddSheet(left.frame, {0, 0, height}, {0, -thick, 0}, {0, 0, -height},
           wall.finish);
  AddSheet(left.frame, {length, -thick, height}, {0, thick, 0}, {0, 0, -height},
           wall.finish);
  builder_.AddPanel(left.frame, {0, 0, height}, {length, 0, 0}, {0, -thick, 0},
                    trim_.white);
}

void BuildingShell::AddGlassWall(const building::PlanWall& wall, int index) {
  const float thick = F(wall.thickness_m);
  building::WallRef ref;
  ref.wall = index;
  const Face left = WallFace(wall, index, true);
  std::vector<WallOpening> openings = OpeningsOf(ref, left);
  std::sort(
      openings.begin(), openings.end(),
      [](const WallOpening& a, const WallOpening& b) { return a.s0 < b.s0; });
  const float height = left.height_m;
  const auto post = [&](float s) {
    builder_.set_kind(SurfaceKind::kOther);
    builder_.AddBox(left.frame, {s, -thick, 0}, {s + 0.04f, 0, height},
                    {.sides = trim_.metal});
  };
  const auto pane = [&](float s0, float s1, float z0, float z1) {
    if (s1 - s0 < 0.1f || z1 - z0 < 0.1f) return;
    builder_.set_kind(SurfaceKind::kOther);
    for (const float z : {z0, z1 - 0.04f}) {
      builder_.AddBox(left.frame, {s0, -thick + 0.001f, z},
                      {s1, -0.001f, z + 0.04f},
                      {.sides = trim_.metal, .has_bottom = z > 0});
    }
    builder_.set_kind(SurfaceKind::kGlass);
    builder_.AddPanel(left.frame, {s1, -thick / 2, z1 - 0.04f}, {s0 - s1, 0, 0},
                      {0, 0, z0 - z1 + 0.08f}, trim_.white);
  };
  float s = 0;
  const auto panes = [&](float end, float z0) {
    // Posts every 1.5 m or so.
    const int count = std::max(1, static_cast<int>((end - s) / 1.5f));
    const float step = (end - s) / F(count);
    for (int i = 0; i < count; ++i) {
      const float s0 = s + step * F(i);
      pane(s0 + 0.04f, s0 + step, z0, height);
      if (z0 == 0) post(s0);
    }
    s = end;
  };
  for (const WallOpening& opening : openings) {
    panes(opening.s0, 0);
    post(opening.s0 - 0.04f);
    panes(opening.s1, opening.z1);
  }
  panes(left.length_m - 0.04f, 0);
  post(s);
}

void BuildingShell::AddPillar(const building::PlanPillar& pillar) {
  const Placement frame = {
      {F(pillar.at.x_m), F(pillar.at.y_m), GroundHeight(plan_, pillar.at)}, 0};
  const float half = F(pillar.width_m / 2);
  const float height = F(pillar.height_m);
  builder_.set_kind(SurfaceKind::kWall);
  const Material& material = MaterialOf(pillar.finish);
  if (pillar.is_round) {
    const WorldBuilder::ProfilePoint profile[] = {
        {half, 0}, {half, height}, {0.001f, height}};
    // Of thin ones there may be many, and 12 sides are round enough.
    builder_.AddTurned(frame, {0, 0, 0}, profile, half < 0.1f ? 12 : 20,
                       {.texture = material.texture,
                        .u1 = 6.28f * half / material.u_m,
                        .v1 = height / material.v_m});
    return;
  }
  for (int side = 0; side < 4; ++side) {
    const Placement turned = frame.At({0, 0, 0}, F(side) * 1.57079633f);
    AddSheet(turned, {half, half, height}, {-2 * half, 0, 0}, {0, 0, -height},
             pillar.finish);
  }
  AddSheet(frame, {-half, half, height}, {2 * half, 0, 0}, {0, -2 * half, 0},
           pillar.finish);
}

}  // namespace treeline::worlds

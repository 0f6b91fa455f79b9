#include "simulation/worlds/building_fittings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "simulation/building/catalogue.h"
#include "simulation/worlds/noise.h"
#include "simulation/worlds/paint_building.h"
#include "simulation/worlds/paint_fronts.h"
#include "simulation/worlds/paint_materials.h"
#include "simulation/worlds/paint_prints.h"

namespace treeline::worlds {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kFrame_m = 0.06f;
constexpr float kLeaf_m = 0.04f;
constexpr double kSwing_s = 2;
constexpr double kTurn_s = 0.8;

float F(double value) { return static_cast<float>(value); }

}  // namespace

Finish BuildingFittings::Painted(std::function<Canvas()> paint, float tile_m,
                                 float emission) {
  return PaintedFinish(builder_, std::move(paint), tile_m, emission);
}

Placement BuildingFittings::StandAt(const building::PlanStand& stand) const {
  return {{F(stand.at.x_m), F(stand.at.y_m), GroundHeight(plan_, stand.at)},
          F(stand.facing_deg * std::numbers::pi / 180)};
}

Placement BuildingFittings::OnWall(const building::PlanOnWall& place,
                                   double at_m) const {
  const building::WallRef ref =
      building::FindWall(plan_, place.wall).value_or(building::WallRef());
  const building::WallFrame at = building::FrameOnWall(plan_, ref, at_m);
  return {{F(at.x_m), F(at.y_m), F(ref.base_m)}, F(at.yaw_rad)};
}

void BuildingFittings::AddReveal(const Placement& frame,
                                 const WallOpening& opening, float thickness_m,
                                 const std::string& floor) {
  const float t = thickness_m;
  const auto& [s0, s1, z0, z1] = opening;
  builder_.set_kind(SurfaceKind::kWall);
  builder_.AddPanel(frame, {s0, 0, z1}, {0, -t, 0}, {0, 0, z0 - z1},
                    trim_.white);
  builder_.AddPanel(frame, {s1, -t, z1}, {0, t, 0}, {0, 0, z0 - z1},
                    trim_.white);
  builder_.AddPanel(frame, {s0, -t, z1}, {s1 - s0, 0, 0}, {0, t, 0},
                    trim_.white);
  if (z0 > 0) {
    builder_.AddPanel(frame, {s0, 0, z0}, {s1 - s0, 0, 0}, {0, -t, 0},
                      trim_.white);
  } else if (!floor.empty()) {
    builder_.set_kind(SurfaceKind::kFloor);
    shell_.AddSheet(frame, {s0, 0, 0}, {s1 - s0, 0, 0}, {0, -t, 0}, floor);
  }
  // Architraves on both faces.
  builder_.set_kind(SurfaceKind::kOther);
  for (const bool is_front : {true, false}) {
    const float y0 = is_front ? 0 : -t - 0.015f;
    const float y1 = is_front ? 0.015f : -t;
    for (const float s : {s0 - kFrame_m, s1}) {
      builder_.AddBox(frame, {s, y0, z0}, {s + kFrame_m, y1, z1 + kFrame_m},
                      {.sides = trim_.white});
    }
    builder_.AddBox(frame, {s0, y0 + 0.001f, z1}, {s1, y1 - 0.001f, z1 + 0.06f},
                    {.sides = trim_.white, .has_bottom = true});
  }
}

void BuildingFittings::AddDoor(const building::PlanDoor& door, int index) {
  const auto ref = building::FindWall(plan_, door.place.wall);
  if (!ref) return;
  const double half = door.width_m / 2;
  const auto behind = building::WallBehind(plan_, *ref, door.place.at_m - half,
                                           door.place.at_m + half);
  const Placement frame = OnWall(door.place, door.place.at_m);
  if (ref->room >= 0 && !behind) return AddOutsideDoor(frame, door);
  const bool is_in_wall = ref->wall >= 0;
  const building::PlanWall* wall =
      is_in_wall ? &plan_.walls[static_cast<size_t>(ref->wall)] : nullptr;
  const float thick = F(is_in_wall ? wall->thickness_m : building::kRoomWall_m);
  const WallOpening opening = {F(-half), F(half), 0, F(door.height_m)};
  if (!is_in_wall) {
    AddReveal(frame, opening, thick,
              plan_.rooms[static_cast<size_t>(ref->room)].floor);
  } else if (!wall->is_glass) {
    AddReveal(frame, opening, thick, "");
  }
  const Placement hinge = frame.At({opening.s0 + 0.005f, -thick / 2, 0});
  switch (door.leaf) {
    case building::DoorLeaf::kNone:
      return;
    case building::DoorLeaf::kOpen:
      // A little more than at right angles, into the room.
      return AddLeaf(frame.At({opening.s0 - 0.03f, 0.04f, 0}, 1.68f), door,
                     index);
    case building::DoorLeaf::kClosed:
      return AddLeaf(hinge, door, index);
    case building::DoorLeaf::kMoving:
      return AddDoorBody(hinge, door, index);
  }
}

void BuildingFittings::AddLeaf(const Placement& hinge,
                               const building::PlanDoor& door, int index) {
  const float width = F(door.width_m) - 0.01f;
  const uint64_t seed =
      base::MixBits(plan_.seed + static_cast<uint64_t>(index));
  const Float3 color = Hsv({CellNoise(index, 1, seed), 0.3f, 0.7f});
  const Finish front = Painted([=] { return PaintDoor(color, seed); });
  builder_.set_kind(SurfaceKind::kOther);
  builder_.AddBox(hinge, {0, -kLeaf_m / 2, 0.008f},
                  {width, kLeaf_m / 2, F(door.height_m) - 0.01f},
                  {.sides = trim_.white, .front = front, .has_bottom = true});
  builder_.AddPanel(hinge, {0, -kLeaf_m / 2 - 0.001f, F(door.height_m) - 0.01f},
                    {width, 0, 0}, {0, 0, 0.018f - F(door.height_m)}, front);
  for (const float y : {kLeaf_m / 2, -kLeaf_m / 2 - 0.05f}) {
    builder_.AddBox(hinge, {width - 0.16f, y, 1.02f},
                    {width - 0.04f, y + 0.05f, 1.045f},
                    {.sides = trim_.metal, .has_bottom = true});
  }
}

void BuildingFittings::AddDoorBody(const Placement& hinge,
                                   const building::PlanDoor& door, int index) {
  builder_.BeginBody();
  AddLeaf({}, door, index);
  Motion motion;
  const auto key = [&](double time_s, float turn_rad) {
    motion.keys.push_back(
        {.time_s = time_s, .world_from_body = hinge.At({0, 0, 0}, turn_rad)});
  };
  const double closed_s = door.period_s - door.open_s - 2 * kSwing_s;
  key(0, 0);
  key(closed_s, 0);
  key(closed_s + kSwing_s, 1.5f);
  key(closed_s + kSwing_s + door.open_s, 1.5f);
  motion.period_s = door.period_s;
  builder_.EndBody(absl::StrCat("door-", index + 1), F(door.width_m),
                   F(door.height_m), std::move(motion));
}

void BuildingFittings::AddOutsideDoor(const Placement& frame,
                                      const building::PlanDoor& door) {
  const float half = F(door.width_m / 2);
  const float high = F(door.height_m);
  const uint64_t seed = furniture_.NextSeed();
  const Float3 color = Hsv({CellNoise(3, 1, seed), 0.35f, 0.65f});
  builder_.set_kind(SurfaceKind::kOther);
  builder_.AddBox(frame, {-half, 0, 0}, {half, 0.025f, high},
                  {.sides = trim_.white,
                   .front = Painted([=] { return PaintDoor(color, seed); })});
  for (const float s : {-half - kFrame_m, half}) {
    builder_.AddBox(frame, {s, 0, 0}, {s + kFrame_m, 0.045f, high + kFrame_m},
                    {.sides = trim_.white});
  }
  builder_.AddBox(frame, {-half, 0, high}, {half, 0.044f, high + kFrame_m},
                  {.sides = trim_.white, .has_bottom = true});
  builder_.AddBox(frame, {half - 0.18f, 0.026f, 1.02f},
                  {half - 0.06f, 0.075f, 1.045f},
                  {.sides = trim_.metal, .has_bottom = true});
}

void BuildingFittings::AddWindow(const building::PlanWindow& window) {
  const auto ref = building::FindWall(plan_, window.place.wall);
  if (!ref) return;
  const double half = window.width_m / 2;
  const Placement frame = OnWall(window.place, window.place.at_m);
  const auto behind = building::WallBehind(
      plan_, *ref, window.place.at_m - half, window.place.at_m + half);
  if (ref->room >= 0 && !behind) return AddView(frame, window);
  const float thick =
      F(ref->wall >= 0 ? plan_.walls[static_cast<size_t>(ref->wall)].thickness_m
                       : building::kRoomWall_m);
  const WallOpening opening = {F(-half), F(half), F(window.low_m),
                               F(window.high_m)};
  AddReveal(frame, opening, thick, "");
  builder_.set_kind(SurfaceKind::kGlass);
  builder_.AddPanel(frame, {opening.s1, -thick / 2, opening.z1},
                    {opening.s0 - opening.s1, 0, 0},
                    {0, 0, opening.z0 - opening.z1}, trim_.white);
}

void BuildingFittings::AddView(const Placement& frame,
                               const building::PlanWindow& window) {
  const float half = F(window.width_m / 2);
  const float low = F(window.low_m);
  const float high = F(window.high_m);
  const uint64_t seed = furniture_.NextSeed();
  builder_.set_kind(SurfaceKind::kOther);
  builder_.AddView(frame, {half, 0, high}, {-2 * half, 0, 0},
                   {0, 0, low - high}, kSkyRadiance,
                   Painted([=] { return PaintWindowView(seed); }, 0, 1.9f));
  const int bars = std::max(2, static_cast<int>(std::lround(half / 0.45f)) + 1);
  for (int i = 0; i <= bars; ++i) {
    const float s = -half + 2 * half * F(i) / F(bars);
    builder_.AddBox(frame, {s - 0.03f, 0, low}, {s + 0.03f, 0.04f, high},
                    {.sides = trim_.white});
  }
  for (const float z : {low - 0.05f, high - 0.01f}) {
    builder_.AddBox(frame, {-half - 0.05f, 0, z},
                    {half + 0.05f, 0.041f, z + 0.06f},
                    {.sides = trim_.white, .has_bottom = true});
  }
  builder_.AddBox(frame, {-half - 0.1f, 0, low - 0.08f},
                  {half + 0.1f, 0.14f, low - 0.051f},
                  {.sides = trim_.white, .has_bottom = true});
}

void BuildingFittings::AddPoster(const building::PlanPoster& poster) {
  const double at = options_.after_moves
                        ? poster.moved_to_m.value_or(poster.place.at_m)
                        : poster.place.at_m;
  const Placement frame = OnWall(poster.place, at);
  builder_.set_kind(SurfaceKind::kOther);
  furniture_.things().Picture(
      frame.At({F(-poster.width_m / 2), 0,
                F(poster.middle_m - poster.height_m / 2)}),
      F(poster.width_m), F(poster.height_m));
}

void BuildingFittings::MakePiece(const building::PlanFurniture& piece) {
  const building::FurnitureKind* kind = building::FindFurniture(piece.kind);
  if (kind == nullptr) return;
  const float width = F(piece.width_m);
  // Pieces face +x of their stand, and have their front towards y.
  const Placement middle = {{0, 0, 0}, -kPi / 2};
  const Placement at = kind->is_centred
                           ? middle
                           : middle.At({-width / 2, F(-kind->depth_m / 2), 0});
  furniture_.ByName(piece.kind, at, width);
}

void BuildingFittings::AddFurniture(const building::PlanFurniture& piece) {
  const building::PlanStand& stand =
      options_.after_moves && piece.moved_to.has_value() ? *piece.moved_to
                                                         : piece.stand;
  builder_.set_kind(SurfaceKind::kOther);
  const auto add = [&](const WorldBuilder::Group& group) {
    const building::FurnitureKind* kind = building::FindFurniture(piece.kind);
    const bool can_move = kind != nullptr && kind->can_move;
    if (can_move) builder_.BeginPiece();
    builder_.AddGroup(group, StandAt(stand));
    if (can_move) builder_.EndPiece();
  };
  const auto make = [&] {
    builder_.BeginGroup();
    MakePiece(piece);
    return builder_.EndGroup();
  };
  if (piece.variant == 0) return add(make());
  const auto key = std::tuple(
      piece.kind, static_cast<int>(std::lround(piece.width_m * 1000)),
      piece.variant);
  auto known = pieces_.find(key);
  if (known == pieces_.end()) known = pieces_.emplace(key, make()).first;
  add(known->second);
}

void BuildingFittings::AddPerson() {
  using ProfilePoint = WorldBuilder::ProfilePoint;
  const uint64_t seed = furniture_.NextSeed();
  const auto clothes = [&](float hue, uint64_t salt) {
    return Painted([=] { return PaintClothes(hue, seed + salt); });
  };
  const Finish shirt = clothes(furniture_.Uniform(0, 1), 1);
  const Finish trousers = clothes(furniture_.Uniform(0.5f, 0.8f), 2);
  const Finish skin = Painted(
      [seed] {
        return PaintPlain({0.80f, 0.60f, 0.48f}, 0.1f, seed);
      },
      0.4f);
  const Finish hair = Painted(
      [seed] {
        return PaintPlain({0.25f, 0.17f, 0.11f}, 0.3f, seed);
      },
      0.4f);
  const ProfilePoint leg[] = {{0.055f, 0}, {0.06f, 0.45f}, {0.085f, 0.86f}};
  builder_.AddTurned({}, {0.04f, 0.1f, 0}, leg, 10, trousers);
  builder_.AddTurned({}, {-0.04f, -0.1f, 0}, leg, 10, trousers);
  const ProfilePoint trunk[] = {{0.17f, 0.82f},
                                {0.16f, 1.05f},
                                {0.19f, 1.35f},
                                {0.13f, 1.46f},
                                {0.05f, 1.50f}};
  builder_.AddTurned({}, {0, 0, 0}, trunk, 14, shirt);
  for (const float y : {-0.23f, 0.23f}) {
    const ProfilePoint arm[] = {
        {0.035f, 0.75f}, {0.05f, 1.1f}, {0.06f, 1.42f}, {0.001f, 1.45f}};
    builder_.AddTurned({}, {0, y, 0}, arm, 8, shirt);
  }
  const ProfilePoint head[] = {
      {0.05f, 1.47f}, {0.06f, 1.52f}, {0.10f, 1.62f}, {0.105f, 1.68f}};
  builder_.AddTurned({}, {0, 0, 0}, head, 12, skin);
  const ProfilePoint crown[] = {
      {0.107f, 1.67f}, {0.10f, 1.74f}, {0.06f, 1.79f}, {0.001f, 1.80f}};
  builder_.AddTurned({}, {0, 0, 0}, crown, 12, hair);
}

void BuildingFittings::AddCart() {
  const uint64_t seed = furniture_.NextSeed();
  const Finish load = Painted([seed] { return PaintCardboard(seed); });
  for (const float x : {-0.4f, 0.34f}) {
    for (const float y : {-0.25f, 0.19f}) {
      builder_.AddBox({}, {x, y, 0}, {x + 0.06f, y + 0.06f, 0.9f},
                      {.sides = trim_.metal});
    }
  }
  for (const float z : {0.18f, 0.6f}) {
    builder_.AddBox({}, {-0.41f, -0.26f, z}, {0.41f, 0.26f, z + 0.03f},
                    {.sides = trim_.metal, .has_bottom = true});
    builder_.AddBox({}, {-0.3f, -0.2f, z + 0.031f}, {0.25f, 0.2f, z + 0.3f},
                    {.sides = load, .front = load, .top = load});
  }
  builder_.AddBox({}, {-0.45f, -0.25f, 0.9f}, {-0.41f, 0.25f, 0.94f},
                  {.sides = trim_.white, .has_bottom = true});
}

Motion BuildingFittings::MotionOf(const building::PlanMover& mover) const {
  Motion motion;
  double time_s = 0;
  const size_t count = mover.path.size();
  const auto point = [&](size_t i) {
    const building::PlanPoint& at = mover.path[i % count].at;
    return Float3{F(at.x_m), F(at.y_m), GroundHeight(plan_, at)};
  };
  const auto heading = [&](size_t i) {
    const Float3 way = point(i + 1) - point(i);
    return std::atan2(way.y, way.x);
  };
  for (size_t i = 0; i < count; ++i) {
    const float before = heading(i + count - 1);
    const auto key = [&](float yaw) {
      motion.keys.push_back(
          {.time_s = time_s, .world_from_body = {point(i), yaw}});
    };
    key(before);
    if (mover.path[i].pause_s > 0) {
      time_s += mover.path[i].pause_s;
      key(before);
    }
    const building::PlanMover::Stop& stop = mover.path[i];
    if (mover.kind != building::MoverKind::kPost) {
      time_s += kTurn_s;
      key(heading(i));
    }
    if (stop.jumps) continue;
    time_s += Norm(point(i + 1) - point(i)) /
              (stop.speed_mps > 0 ? stop.speed_mps : mover.speed_mps);
  }
  motion.period_s = time_s;
  return motion;
}

void BuildingFittings::AddMover(const building::PlanMover& mover) {
  builder_.set_kind(SurfaceKind::kOther);
  builder_.BeginBody();
  switch (mover.kind) {
    case building::MoverKind::kPerson:
      AddPerson();
      builder_.EndBody(mover.name, 0.3f, 1.8f, MotionOf(mover));
      return;
    case building::MoverKind::kCart:
      AddCart();
      builder_.EndBody(mover.name, 0.52f, 0.94f, MotionOf(mover));
      return;
    case building::MoverKind::kPost:
      break;
  }
  const float radius = F(mover.width_m / 2);
  const float height = F(mover.height_m);
  const WorldBuilder::ProfilePoint profile[] = {
      {radius, 0}, {radius, height}, {0.001f, height}};
  builder_.AddTurned({}, {0, 0, 0}, profile, 20, trim_.metal);
  builder_.EndBody(mover.name, radius, height, MotionOf(mover));
}

void BuildingFittings::AddCrate() {
  builder_.set_kind(SurfaceKind::kOther);
  const Finish face =
      Painted([seed = plan_.seed] { return PaintCardboard(seed + 77); });
  builder_.BeginBody();
  builder_.AddBox({}, {-0.5f, -0.5f, 0}, {0.5f, 0.5f, 1},
                  {.sides = face, .front = face, .top = face});
  builder_.EndBody("crate", 0.7072f, 1, std::nullopt);
}

}  // namespace treeline::worlds

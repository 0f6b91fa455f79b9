#include "simulation/building/plan_fitter.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "simulation/building/catalogue.h"

namespace treeline::building {
namespace {

// Half of what is kept free along the tour.
constexpr double kAisle_m = 0.55;
constexpr double kRobotRoom_m = 0.75;
// Between what hangs on a wall.
constexpr double kPosterGap_m = 0.2;
constexpr int kAttemptsAtWall = 8;

std::array<double, 3> DrawColor(double low, double high, PlanDice& dice) {
  const double bright = dice.Uniform(low, high);
  return {RoundToCm(std::min(1.0, bright * dice.Uniform(0.8, 1.15))),
          RoundToCm(std::min(1.0, bright * dice.Uniform(0.8, 1.1))),
          RoundToCm(std::min(1.0, bright * dice.Uniform(0.7, 1.1)))};
}

}  // namespace

double RoundToCm(double value) { return std::round(value * 100) / 100; }

double PlanFrame::Facing(double facing_deg) const {
  double facing = facing_deg;
  if (mirrors_x) facing = 180 - facing;
  if (mirrors_y) facing = -facing;
  return RoundToCm(std::fmod(facing + 720, 360));
}

PlanOnWall PlanFrame::OnWall(const std::string& room, PlanSide side,
                             double at) const {
  constexpr std::array<const char*, 4> kNames = {".south", ".east", ".north",
                                                 ".west"};
  const bool is_along_x = side == kSouth || side == kNorth;
  const bool is_turned_over = is_along_x ? mirrors_y : mirrors_x;
  const size_t name =
      (static_cast<size_t>(side) + (is_turned_over ? 2 : 0)) % kNames.size();
  return {room + kNames[name], is_along_x ? X(at) : Y(at)};
}

PlanLooks DrawFinishes(int floors, int walls, PlanDice& dice,
                       BuildingPlan& plan) {
  const std::vector<std::string> floor_materials = {"planks", "tiles", "carpet",
                                                    "planks"};
  const std::vector<std::string> wall_materials = {
      "plaster", "wallpaper", "brick", "concrete", "plaster", "wallpaper"};
  PlanLooks looks;
  for (int i = 0; i < floors; ++i) {
    looks.floors.push_back(absl::StrCat("floor-", i + 1));
    const std::string& material = dice.Pick(floor_materials);
    plan.finishes.push_back(
        {looks.floors.back(), material, DrawColor(0.4, 0.72, dice)});
  }
  for (int i = 0; i < walls; ++i) {
    looks.walls.push_back(absl::StrCat("wall-", i + 1));
    const std::string& material = dice.Pick(wall_materials);
    plan.finishes.push_back(
        {looks.walls.back(), material, DrawColor(0.55, 0.92, dice)});
  }
  looks.walls.emplace_back("white");
  return looks;
}

void PlanFitter::KeepLeg(std::array<double, 2> a, std::array<double, 2> b) {
  const auto [x0, x1] = std::minmax(a[0], b[0]);
  const auto [y0, y1] = std::minmax(a[1], b[1]);
  Keep(x0 - kAisle_m, y0 - kAisle_m, x1 + kAisle_m, y1 + kAisle_m);
}

void PlanFitter::AddPlace(const std::string& name, double x, double y,
                          double facing) {
  plan_.places.push_back({name, {frame_.Point(x, y), frame_.Facing(facing)}});
  Keep(x - kRobotRoom_m, y - kRobotRoom_m, x + kRobotRoom_m, y + kRobotRoom_m);
}

void PlanFitter::AddDoor(const PlanOnWall& place, double width_m,
                         DoorLeaf leaf) {
  PlanDoor door;
  door.place = place;
  door.leaf = leaf;
  door.width_m = width_m;
  plan_.doors.push_back(door);
  Note(place, door.width_m);
}

void PlanFitter::AddWindow(const PlanOnWall& place) {
  PlanWindow window;
  window.place = place;
  window.width_m = dice_.Uniform(1.2, 1.8);
  plan_.windows.push_back(window);
  Note(place, window.width_m);
}

bool PlanFitter::Place(const std::string& kind, double x, double y,
                       double facing, int variant) {
  const FurnitureKind* found = FindFurniture(kind);
  if (found == nullptr) return false;
  const bool is_turned = facing == 0 || facing == 180;
  const double half_x = (is_turned ? found->depth_m : found->width_m) / 2;
  const double half_y = (is_turned ? found->width_m : found->depth_m) / 2;
  const double reach = kind == "plant" ? 0.25 : 0.02;
  const PlanArea area = {x - half_x - reach, y - half_y - reach,
                         x + half_x + reach, y + half_y + reach};
  for (const PlanArea& other : taken_) {
    if (area.Overlaps(other)) return false;
  }
  taken_.push_back(area);
  PlanFurniture piece;
  piece.kind = kind;
  piece.stand = {frame_.Point(x, y), frame_.Facing(facing)};
  piece.width_m = found->width_m;
  piece.variant = variant;
  plan_.furniture.push_back(piece);
  return true;
}

void PlanFitter::PlaceAtWall(const std::string& kind, const PlanArea& area,
                             PlanSide side, int variant) {
  const FurnitureKind* found = FindFurniture(kind);
  if (found == nullptr) return;
  const bool is_plant = kind == "plant";
  const double away = 0.09 + found->depth_m / 2 + (is_plant ? 0.2 : 0);
  const double along = found->width_m / 2 + (is_plant ? 0.4 : 0.12);
  const bool is_along_x = side == kSouth || side == kNorth;
  const double low = (is_along_x ? area.x0_m : area.y0_m) + along;
  const double high = (is_along_x ? area.x1_m : area.y1_m) - along;
  if (high <= low) return;
  for (int i = 0; i < kAttemptsAtWall; ++i) {
    const double at = dice_.Uniform(low, high);
    bool is_placed = false;
    switch (side) {
      case kSouth:
        is_placed = Place(kind, at, RoundToCm(area.y0_m + away), 90, variant);
        break;
      case kNorth:
        is_placed = Place(kind, at, RoundToCm(area.y1_m - away), 270, variant);
        break;
      case kWest:
        is_placed = Place(kind, RoundToCm(area.x0_m + away), at, 0, variant);
        break;
      case kEast:
        is_placed = Place(kind, RoundToCm(area.x1_m - away), at, 180, variant);
        break;
    }
    if (is_placed) return;
  }
}

void PlanFitter::Note(const PlanOnWall& place, double width_m) {
  hung_.push_back({place.wall, place.at_m - width_m / 2 - kPosterGap_m,
                   place.at_m + width_m / 2 + kPosterGap_m});
}

void PlanFitter::HangPoster(const std::string& room, PlanSide side, double low,
                            double high) {
  PlanPoster poster;
  poster.width_m = dice_.Uniform(0.4, 1.2);
  poster.height_m = dice_.Uniform(0.4, 0.9);
  poster.middle_m = dice_.Uniform(1.5, 1.9);
  const double margin = poster.width_m / 2 + kPosterGap_m;
  if (high - low < 2 * margin) return;
  poster.place =
      frame_.OnWall(room, side, dice_.Uniform(low + margin, high - margin));
  for (const Hung& other : hung_) {
    if (other.wall == poster.place.wall &&
        other.from < poster.place.at_m + poster.width_m / 2 &&
        other.to > poster.place.at_m - poster.width_m / 2) {
      return;
    }
  }
  Note(poster.place, poster.width_m);
  plan_.posters.push_back(poster);
}

}  // namespace treeline::building

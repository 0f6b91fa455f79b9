#include "simulation/building/plan_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "simulation/building/catalogue.h"

namespace treeline::building {
namespace {

// Half of what is kept free along the tour.
constexpr double kAisle_m = 0.55;
constexpr double kRobotRoom_m = 0.75;

// To the centimetre, so that a file holds exactly the same numbers.
double Round(double value) { return std::round(value * 100) / 100; }

class PlanDrawer {
 public:
  PlanDrawer(uint64_t seed, int attempt)
      : random_(base::MixBits(seed) + static_cast<uint64_t>(attempt), 0xb1d) {
    plan_.seed = base::MixBits(seed + 1) >> 12;
  }

  BuildingPlan Draw() {
    DrawMeasures();
    DrawFinishes();
    AddRooms();
    AddRise();
    AddDoorsAndWindows();
    AddTour();
    Furnish();
    AddPosters();
    AddMovers();
    return std::move(plan_);
  }

 private:
  double Uniform(double low, double high) {
    return Round(random_.NextUniform(low, high));
  }
  bool Chance(double share) { return random_.NextUnit() < share; }
  const std::string& Pick(const std::vector<std::string>& from) {
    return from[random_.NextBelow(static_cast<uint32_t>(from.size()))];
  }

  // ---- drawn with the hall on the left and its ramp in front, then mirrored
  // by chance ----

  double X(double x) const { return Round(mirror_x_ ? width_ - x : x); }
  double Y(double y) const { return Round(mirror_y_ ? depth_ - y : y); }
  PlanPoint Point(double x, double y) const { return {X(x), Y(y), {}}; }
  PlanArea Area(double x0, double y0, double x1, double y1) const {
    const auto [low_x, high_x] = std::minmax({X(x0), X(x1)});
    const auto [low_y, high_y] = std::minmax({Y(y0), Y(y1)});
    return {low_x, low_y, high_x, high_y};
  }
  double Facing(double facing_deg) const {
    double facing = facing_deg;
    if (mirror_x_) facing = 180 - facing;
    if (mirror_y_) facing = -facing;
    return Round(std::fmod(facing + 720, 360));
  }
  PlanSide Side(PlanSide side) const {
    const bool is_x = side == kEast || side == kWest;
    return (is_x ? mirror_x_ : mirror_y_)
               ? static_cast<PlanSide>((side + 2) % 4)
               : side;
  }
  PlanOnWall OnWall(const std::string& room, PlanSide side, double at) const {
    constexpr const char* kNames[] = {".south", ".east", ".north", ".west"};
    const bool is_along_x = side == kSouth || side == kNorth;
    return {room + kNames[Side(side)], is_along_x ? X(at) : Y(at)};
  }

  void DrawMeasures() {
    mirror_x_ = Chance(0.5);
    mirror_y_ = Chance(0.5);
    width_ = Uniform(9.4, 14);
    depth_ = Uniform(7.2, 10);
    plan_.size_m = {width_, depth_, Uniform(2.7, 3.3)};
    hall_ = Round(width_ - Uniform(2.8, 3.4));
    count_ = Chance(0.4) ? 3 : 2;
    rise_ = Uniform(0.16, 0.18);
    double steepness = Uniform(8, 12);
    // The way up, a platform above and a robot's room below must fit.
    const double longest = hall_ - 3.6;
    if (count_ * rise_ * steepness > longest) count_ = 2;
    if (count_ * rise_ * steepness > longest) steepness = 8;
    if (count_ * rise_ * steepness > longest) rise_ = 0.16;
    height_ = Round(count_ * rise_);
    run_ = std::ceil(height_ * steepness * 100) / 100;
    ramp_width_ = Uniform(1.1, 1.5);
    platform_x_ = Uniform(run_ + 1.55, hall_ - 2);
    platform_y_ = Uniform(3, std::max(3.05, depth_ - 3.1));
    aisle_y_ = Round(platform_y_ + 0.8 + Uniform(0, 0.3));
    approach_x_ = Round(std::max(0.8, platform_x_ - run_ - 0.75));
    ramp_y_ = Round(0.05 + ramp_width_ / 2);
    side_x_ = Round(hall_ + (width_ - hall_) / 2 + Uniform(-0.25, 0.25));
  }

  std::array<double, 3> Color(double low, double high) {
    const double bright = Uniform(low, high);
    return {Round(std::min(1.0, bright * Uniform(0.8, 1.15))),
            Round(std::min(1.0, bright * Uniform(0.8, 1.1))),
            Round(std::min(1.0, bright * Uniform(0.7, 1.1)))};
  }

  void DrawFinishes() {
    const std::vector<std::string> floors = {"planks", "tiles", "carpet",
                                             "planks"};
    const std::vector<std::string> walls = {
        "plaster", "wallpaper", "brick", "concrete", "plaster", "wallpaper"};
    for (int i = 0; i < 3; ++i) {
      floors_.push_back(absl::StrCat("floor-", i + 1));
      plan_.finishes.push_back(
          {floors_.back(), Pick(floors), Color(0.4, 0.72)});
    }
    for (int i = 0; i < 5; ++i) {
      walls_.push_back(absl::StrCat("wall-", i + 1));
      plan_.finishes.push_back({walls_.back(), Pick(walls), Color(0.55, 0.92)});
    }
    walls_.push_back("white");
  }

  void AddRoom(const std::string& name, const PlanArea& area, PlanLamps lamps) {
    PlanRoom room;
    room.name = name;
    room.area = area;
    room.height_m = plan_.size_m[2];
    room.floor = Pick(floors_);
    for (std::string& wall : room.walls) wall = Pick(walls_);
    room.lamps = lamps;
    plan_.rooms.push_back(room);
  }

  void AddRooms() {
    AddRoom("hall", Area(0, 0, hall_, depth_), {3, 2});
    // Rooms beside the hall, from the back; each has its lower end.
    double top = depth_;
    const double last = std::min(aisle_y_ - 0.75, depth_ - 2.6);
    if (Chance(0.7)) {
      side_ends_.push_back(Uniform(2.6, last));
      if (side_ends_[0] >= 5.2) {
        side_ends_.push_back(Uniform(2.5, side_ends_[0] - 2.5));
      }
    }
    side_ends_.push_back(0);
    for (size_t i = 0; i < side_ends_.size(); ++i) {
      const std::string name = absl::StrCat("room-", i + 1);
      AddRoom(name, Area(hall_, side_ends_[i], width_, top),
              {1, top - side_ends_[i] > 4.5 ? 2 : 1});
      top = side_ends_[i];
    }
  }

  void AddRise() {
    PlanPlatform platform;
    platform.name = "platform";
    platform.area = Area(platform_x_, 0, hall_, platform_y_);
    platform.height_m = height_;
    platform.floor = Pick(floors_);
    platform.sides = Chance(0.5) ? "concrete" : "wood";
    plan_.platforms.push_back(platform);

    PlanRamp ramp;
    ramp.name = "ramp";
    ramp.from = Point(platform_x_ - run_, ramp_y_);
    ramp.to = Point(platform_x_, ramp_y_);
    ramp.from.z_m = 0;
    ramp.to.z_m = height_;
    ramp.width_m = ramp_width_;
    const bool is_mirrored = mirror_x_ != mirror_y_;
    if (Chance(0.4)) {
      (is_mirrored ? ramp.right_wall_m : ramp.left_wall_m) = Uniform(0.2, 0.6);
    }
    plan_.ramps.push_back(ramp);
    Keep(platform_x_ - run_ - 1.3, 0, hall_ - 0.9, ramp_width_ + 0.2);

    PlanStairs stairs;
    stairs.name = "stairs";
    stairs.run_m = Uniform(0.26, 0.3);
    stairs.rise_m = rise_;
    stairs.count = count_;
    stairs.width_m = Uniform(0.8, 1.0);
    const double y = Uniform(ramp_width_ + 0.3 + stairs.width_m / 2,
                             platform_y_ - 0.1 - stairs.width_m / 2);
    stairs.from = Point(platform_x_ - stairs.run_m * count_, y);
    stairs.facing_deg = Facing(0);
    plan_.stairs.push_back(stairs);
    Keep(platform_x_ - 1.9, y - 0.5, platform_x_ + 0.6, y + 0.5);
  }

  void AddDoorsAndWindows() {
    const auto leaf = [&] {
      return Chance(0.3) ? DoorLeaf::kOpen : DoorLeaf::kNone;
    };
    AddDoor(OnWall("hall", kEast, aisle_y_), leaf());
    for (size_t i = 1; i < side_ends_.size(); ++i) {
      AddDoor(OnWall(absl::StrCat("room-", i), kSouth, side_x_),
              DoorLeaf::kNone);
    }
    entrance_y_ = Round(aisle_y_ + Uniform(-0.2, 0.2));
    AddDoor(OnWall("hall", kWest, entrance_y_), DoorLeaf::kClosed);
    AddWindow(OnWall("hall", kNorth, Uniform(1.6, hall_ - 1.6)));
    AddWindow(OnWall("room-1", kEast, Round(depth_ - 1.3)));
    if (side_ends_.size() > 1) {
      AddWindow(OnWall(absl::StrCat("room-", side_ends_.size()), kSouth,
                       Round((hall_ + width_) / 2)));
    }
  }

  void AddDoor(const PlanOnWall& place, DoorLeaf leaf) {
    PlanDoor door;
    door.place = place;
    door.leaf = leaf;
    door.width_m = 1;
    plan_.doors.push_back(door);
    Note(place, door.width_m);
  }

  void AddWindow(const PlanOnWall& place) {
    PlanWindow window;
    window.place = place;
    window.width_m = Uniform(1.2, 1.8);
    plan_.windows.push_back(window);
    Note(place, window.width_m);
  }

  // ---- the tour, along which everything stays free ----

  void AddTour() {
    const auto corner = [&](double x, double y) {
      plan_.tour.push_back(Point(x, y));
      if (!corners_.empty()) KeepLeg(corners_.back(), {x, y});
      corners_.push_back({x, y});
    };
    const double inner = side_ends_.size() > 1
                             ? Round(std::max(side_ends_.back(), 0.0) + 1.3)
                             : 1.3;
    corner(approach_x_, aisle_y_);
    corner(side_x_, aisle_y_);
    corner(side_x_, inner);
    corner(side_x_, aisle_y_);
    corner(approach_x_, aisle_y_);
    corner(approach_x_, ramp_y_);
    corner(platform_x_ - run_, ramp_y_);
    corner(platform_x_, ramp_y_);
    corner(hall_ - 1, ramp_y_);
    corner(platform_x_, ramp_y_);
    corner(platform_x_ - run_, ramp_y_);
    corner(approach_x_, ramp_y_);
    AddPlace("start", approach_x_, aisle_y_, 0);
    AddPlace("platform", hall_ - 1, ramp_y_, 180);
    double top = depth_;
    for (size_t i = 0; i < side_ends_.size(); ++i) {
      const double y = i == 0 ? aisle_y_ : Round((top + side_ends_[i]) / 2);
      AddPlace(absl::StrCat("room-", i + 1), side_x_, y, 90);
      top = side_ends_[i];
    }
  }

  void AddPlace(const std::string& name, double x, double y, double facing) {
    plan_.places.push_back({name, {Point(x, y), Facing(facing)}});
    Keep(x - kRobotRoom_m, y - kRobotRoom_m, x + kRobotRoom_m,
         y + kRobotRoom_m);
  }

  void Keep(double x0, double y0, double x1, double y1) {
    taken_.push_back({x0, y0, x1, y1});
  }
  void KeepLeg(std::array<double, 2> a, std::array<double, 2> b) {
    const auto [x0, x1] = std::minmax(a[0], b[0]);
    const auto [y0, y1] = std::minmax(a[1], b[1]);
    Keep(x0 - kAisle_m, y0 - kAisle_m, x1 + kAisle_m, y1 + kAisle_m);
  }

  // ---- furniture ----

  // Puts a piece where it does not cover what is taken already.
  bool Place(const std::string& name, double x, double y, double facing,
             int variant = 0) {
    const FurnitureKind* kind = FindFurniture(name);
    if (kind == nullptr) return false;
    const bool is_turned = facing == 0 || facing == 180;
    const double half_x = (is_turned ? kind->depth_m : kind->width_m) / 2;
    const double half_y = (is_turned ? kind->width_m : kind->depth_m) / 2;
    const double reach = name == "plant" ? 0.25 : 0.02;
    const PlanArea area = {x - half_x - reach, y - half_y - reach,
                           x + half_x + reach, y + half_y + reach};
    for (const PlanArea& other : taken_) {
      if (area.Overlaps(other)) return false;
    }
    taken_.push_back(area);
    PlanFurniture piece;
    piece.kind = name;
    piece.stand = {Point(x, y), Facing(facing)};
    piece.width_m = kind->width_m;
    piece.variant = variant;
    plan_.furniture.push_back(piece);
    return true;
  }

  // Somewhere along a wall of the part of the hall or room that is `area`.
  void PlaceAtWall(const std::string& name, const PlanArea& area,
                   PlanSide side) {
    const FurnitureKind* kind = FindFurniture(name);
    if (kind == nullptr) return;
    const double away = 0.09 + kind->depth_m / 2 + (name == "plant" ? 0.2 : 0);
    const double along = kind->width_m / 2 + (name == "plant" ? 0.4 : 0.12);
    for (int i = 0; i < 8; ++i) {
      const bool is_along_x = side == kSouth || side == kNorth;
      const double low = (is_along_x ? area.x0_m : area.y0_m) + along;
      const double high = (is_along_x ? area.x1_m : area.y1_m) - along;
      if (high <= low) return;
      const double at = Uniform(low, high);
      bool is_placed = false;
      switch (side) {
        case kSouth:
          is_placed = Place(name, at, Round(area.y0_m + away), 90);
          break;
        case kNorth:
          is_placed = Place(name, at, Round(area.y1_m - away), 270);
          break;
        case kWest:
          is_placed = Place(name, Round(area.x0_m + away), at, 0);
          break;
        case kEast:
          is_placed = Place(name, Round(area.x1_m - away), at, 180);
          break;
      }
      if (is_placed) return;
    }
  }

  void Furnish() {
    const PlanArea hall = {0, 0, hall_, depth_};
    const PlanArea back = {0, aisle_y_, hall_, depth_};
    const PlanArea above = {platform_x_ + 0.4, 0, hall_, platform_y_ - 0.4};
    const std::vector<std::string> large = {"bookcase", "sideboard", "sofa",
                                            "wardrobe", "machine",   "rack",
                                            "bench",    "counter"};
    const std::vector<std::string> small = {"plant",      "boxes", "bin",
                                            "floor_lamp", "crate", "stool"};
    for (int i = 0; i < 4; ++i) PlaceAtWall(Pick(large), back, kNorth);
    for (int i = 0; i < 2; ++i) PlaceAtWall(Pick(large), hall, kWest);
    for (int i = 0; i < 2; ++i) PlaceAtWall(Pick(small), hall, kWest);
    PlaceAtWall(Pick(small), back, kEast);
    PlaceAtWall(Pick(large), above, kEast);
    PlaceAtWall(Pick(small), above, kEast);
    FurnishMiddle();
    double top = depth_;
    for (const double end : side_ends_) {
      const PlanArea room = {hall_, end, width_, top};
      PlaceAtWall(Chance(0.5) ? "desk" : "table", room, kEast);
      PlaceAtWall(Pick(large), room, kEast);
      PlaceAtWall(Pick(large), room, kNorth);
      PlaceAtWall(Pick(small), room, kWest);
      PlaceAtWall(Pick(small), room, kSouth);
      top = end;
    }
  }

  // Small tables with chairs, all alike, where there is room for them.
  void FurnishMiddle() {
    const int variant = 1;
    for (int i = 0; i < 10; ++i) {
      const double x = Uniform(1, hall_ - 1);
      const double y = Uniform(1.2, depth_ - 1.2);
      const bool is_below_edge = x > platform_x_ - 0.9 &&
                                 y > platform_y_ - 1.3 && y < platform_y_ + 1.2;
      if (is_below_edge || !Place("cafe_table", x, y, 90, variant)) continue;
      Place("chair", x, Round(y + 0.72), 270, variant);
      Place("chair", x, Round(y - 0.72), 90, variant);
      if (Chance(0.5)) Place("chair", Round(x + 0.72), y, 180, variant);
    }
  }

  // ---- walls ----

  // What is on walls already, by wall: from and to.
  struct Hung {
    std::string wall;
    double from = 0;
    double to = 0;
  };
  void Note(const PlanOnWall& place, double width) {
    hung_.push_back({place.wall, place.at_m - width / 2 - 0.2,
                     place.at_m + width / 2 + 0.2});
  }

  void HangPoster(const std::string& room, PlanSide side, double low,
                  double high) {
    PlanPoster poster;
    poster.width_m = Uniform(0.4, 1.2);
    poster.height_m = Uniform(0.4, 0.9);
    poster.middle_m = Uniform(1.5, 1.9);
    const double margin = poster.width_m / 2 + 0.2;
    if (high - low < 2 * margin) return;
    poster.place = OnWall(room, side, Uniform(low + margin, high - margin));
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

  void AddPosters() {
    for (int i = 0; i < 7; ++i) {
      HangPoster("hall", kSouth, 0, hall_);
      HangPoster("hall", kNorth, 0, hall_);
    }
    for (int i = 0; i < 4; ++i) {
      HangPoster("hall", kWest, 0, depth_);
      HangPoster("hall", kEast, 0, depth_);
    }
    double top = depth_;
    for (size_t i = 0; i < side_ends_.size(); ++i) {
      const std::string room = absl::StrCat("room-", i + 1);
      for (int k = 0; k < 2; ++k) {
        HangPoster(room, kWest, side_ends_[i], top);
        HangPoster(room, kEast, side_ends_[i], top);
        HangPoster(room, kNorth, hall_, width_);
        HangPoster(room, kSouth, hall_, width_);
      }
      top = side_ends_[i];
    }
  }

  void AddMovers() {
    PlanMover person;
    person.name = "person";
    person.speed_mps = Uniform(0.6, 1.2);
    person.path = {{Point(approach_x_, aisle_y_), Uniform(0, 6)},
                   {Point(hall_ - 0.8, aisle_y_), Uniform(0, 6)}};
    plan_.movers.push_back(person);
  }

  base::Random random_;
  BuildingPlan plan_;
  bool mirror_x_ = false;
  bool mirror_y_ = false;
  double width_ = 0;
  double depth_ = 0;
  double hall_ = 0;  // where the hall ends
  int count_ = 2;    // of steps
  double rise_ = 0;
  double height_ = 0;  // of the platform
  double run_ = 0;     // of the ramp
  double ramp_width_ = 0;
  double ramp_y_ = 0;
  double platform_x_ = 0;
  double platform_y_ = 0;
  double aisle_y_ = 0;
  double approach_x_ = 0;
  double side_x_ = 0;
  double entrance_y_ = 0;
  std::vector<double> side_ends_;
  std::vector<std::string> floors_;
  std::vector<std::string> walls_;
  std::vector<std::array<double, 2>> corners_;
  std::vector<PlanArea> taken_;
  std::vector<Hung> hung_;
};

}  // namespace

BuildingPlan DrawPlan(uint64_t seed, int attempt) {
  return PlanDrawer(seed, attempt).Draw();
}

}  // namespace treeline::building

#include "simulation/building/plan_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "simulation/building/plan_fitter.h"

namespace treeline::building {
namespace {

constexpr double kDoor_m = 1;

class PlanDrawer {
 public:
  PlanDrawer(uint64_t seed, int attempt)
      : dice_(base::MixBits(seed) + static_cast<uint64_t>(attempt), 0xb1d),
        fitter_(dice_, plan_, frame_) {
    plan_.seed = base::MixBits(seed + 1) >> 12;
  }

  BuildingPlan Draw() {
    DrawMeasures();
    looks_ = DrawFinishes(3, 5, dice_, plan_);
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
  void DrawMeasures() {
    frame_.mirrors_x = dice_.Chance(0.5);
    frame_.mirrors_y = dice_.Chance(0.5);
    frame_.width_m = dice_.Uniform(9.4, 14);
    frame_.depth_m = dice_.Uniform(7.2, 10);
    plan_.size_m = {frame_.width_m, frame_.depth_m, dice_.Uniform(2.7, 3.3)};
    hall_ = RoundToCm(frame_.width_m - dice_.Uniform(2.8, 3.4));
    count_ = dice_.Chance(0.4) ? 3 : 2;
    rise_ = dice_.Uniform(0.16, 0.18);
    double steepness = dice_.Uniform(8, 12);
    // The way up, a platform above and a robot's room below must fit.
    const double longest = hall_ - 3.6;
    if (count_ * rise_ * steepness > longest) count_ = 2;
    if (count_ * rise_ * steepness > longest) steepness = 8;
    if (count_ * rise_ * steepness > longest) rise_ = 0.16;
    height_ = RoundToCm(count_ * rise_);
    run_ = std::ceil(height_ * steepness * 100) / 100;
    ramp_width_ = dice_.Uniform(1.1, 1.5);
    platform_x_ = dice_.Uniform(run_ + 1.55, hall_ - 2);
    platform_y_ = dice_.Uniform(3, std::max(3.05, frame_.depth_m - 3.1));
    aisle_y_ = RoundToCm(platform_y_ + 0.8 + dice_.Uniform(0, 0.3));
    approach_x_ = RoundToCm(std::max(0.8, platform_x_ - run_ - 0.75));
    ramp_y_ = RoundToCm(0.05 + ramp_width_ / 2);
    side_x_ = RoundToCm(hall_ + (frame_.width_m - hall_) / 2 +
                        dice_.Uniform(-0.25, 0.25));
  }

  void AddRoom(const std::string& name, const PlanArea& area, PlanLamps lamps) {
    PlanRoom room;
    room.name = name;
    room.area = area;
    room.height_m = plan_.size_m[2];
    room.floor = dice_.Pick(looks_.floors);
    for (std::string& wall : room.walls) wall = dice_.Pick(looks_.walls);
    room.lamps = lamps;
    plan_.rooms.push_back(room);
  }

  void AddRooms() {
    AddRoom("hall", frame_.Area(0, 0, hall_, frame_.depth_m), {3, 2});
    // Rooms beside the hall, from the back; each has its lower end.
    double top = frame_.depth_m;
    const double last = std::min(aisle_y_ - 0.75, frame_.depth_m - 2.6);
    if (dice_.Chance(0.7)) {
      side_ends_.push_back(dice_.Uniform(2.6, last));
      if (side_ends_[0] >= 5.2) {
        side_ends_.push_back(dice_.Uniform(2.5, side_ends_[0] - 2.5));
      }
    }
    side_ends_.push_back(0);
    for (size_t i = 0; i < side_ends_.size(); ++i) {
      const std::string name = absl::StrCat("room-", i + 1);
      AddRoom(name, frame_.Area(hall_, side_ends_[i], frame_.width_m, top),
              {1, top - side_ends_[i] > 4.5 ? 2 : 1});
      top = side_ends_[i];
    }
  }

  void AddRise() {
    PlanPlatform platform;
    platform.name = "platform";
    platform.area = frame_.Area(platform_x_, 0, hall_, platform_y_);
    platform.height_m = height_;
    platform.floor = dice_.Pick(looks_.floors);
    platform.sides = dice_.Chance(0.5) ? "concrete" : "wood";
    plan_.platforms.push_back(platform);

    PlanRamp ramp;
    ramp.name = "ramp";
    ramp.from = frame_.Point(platform_x_ - run_, ramp_y_);
    ramp.to = frame_.Point(platform_x_, ramp_y_);
    ramp.from.z_m = 0;
    ramp.to.z_m = height_;
    ramp.width_m = ramp_width_;
    const bool is_mirrored = frame_.mirrors_x != frame_.mirrors_y;
    if (dice_.Chance(0.4)) {
      (is_mirrored ? ramp.right_wall_m : ramp.left_wall_m) =
          dice_.Uniform(0.2, 0.6);
    }
    plan_.ramps.push_back(ramp);
    fitter_.Keep(platform_x_ - run_ - 1.3, 0, hall_ - 0.9, ramp_width_ + 0.2);

    PlanStairs stairs;
    stairs.name = "stairs";
    stairs.run_m = dice_.Uniform(0.26, 0.3);
    stairs.rise_m = rise_;
    stairs.count = count_;
    stairs.width_m = dice_.Uniform(0.8, 1.0);
    const double y = dice_.Uniform(ramp_width_ + 0.3 + stairs.width_m / 2,
                                   platform_y_ - 0.1 - stairs.width_m / 2);
    stairs.from = frame_.Point(platform_x_ - stairs.run_m * count_, y);
    stairs.facing_deg = frame_.Facing(0);
    plan_.stairs.push_back(stairs);
    fitter_.Keep(platform_x_ - 1.9, y - 0.5, platform_x_ + 0.6, y + 0.5);
  }

  void AddDoorsAndWindows() {
    const auto leaf = [&] {
      return dice_.Chance(0.3) ? DoorLeaf::kOpen : DoorLeaf::kNone;
    };
    fitter_.AddDoor(frame_.OnWall("hall", kEast, aisle_y_), kDoor_m, leaf());
    for (size_t i = 1; i < side_ends_.size(); ++i) {
      fitter_.AddDoor(frame_.OnWall(absl::StrCat("room-", i), kSouth, side_x_),
                      kDoor_m, DoorLeaf::kNone);
    }
    entrance_y_ = RoundToCm(aisle_y_ + dice_.Uniform(-0.2, 0.2));
    fitter_.AddDoor(frame_.OnWall("hall", kWest, entrance_y_), kDoor_m,
                    DoorLeaf::kClosed);
    fitter_.AddWindow(
        frame_.OnWall("hall", kNorth, dice_.Uniform(1.6, hall_ - 1.6)));
    fitter_.AddWindow(
        frame_.OnWall("room-1", kEast, RoundToCm(frame_.depth_m - 1.3)));
    if (side_ends_.size() > 1) {
      fitter_.AddWindow(frame_.OnWall(absl::StrCat("room-", side_ends_.size()),
                                      kSouth,
                                      RoundToCm((hall_ + frame_.width_m) / 2)));
    }
  }

  // ---- the tour, along which everything stays free ----

  void AddTour() {
    const auto corner = [&](double x, double y) {
      plan_.tour.push_back(frame_.Point(x, y));
      if (!corners_.empty()) fitter_.KeepLeg(corners_.back(), {x, y});
      corners_.push_back({x, y});
    };
    const double inner = side_ends_.size() > 1
                             ? RoundToCm(std::max(side_ends_.back(), 0.0) + 1.3)
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
    fitter_.AddPlace("start", approach_x_, aisle_y_, 0);
    fitter_.AddPlace("platform", hall_ - 1, ramp_y_, 180);
    double top = frame_.depth_m;
    for (size_t i = 0; i < side_ends_.size(); ++i) {
      const double y = i == 0 ? aisle_y_ : RoundToCm((top + side_ends_[i]) / 2);
      fitter_.AddPlace(absl::StrCat("room-", i + 1), side_x_, y, 90);
      top = side_ends_[i];
    }
  }

  // ---- furniture ----

  void Furnish() {
    const PlanArea hall = {0, 0, hall_, frame_.depth_m};
    const PlanArea back = {0, aisle_y_, hall_, frame_.depth_m};
    const PlanArea above = {platform_x_ + 0.4, 0, hall_, platform_y_ - 0.4};
    const std::vector<std::string> large = {"bookcase", "sideboard", "sofa",
                                            "wardrobe", "machine",   "rack",
                                            "bench",    "counter"};
    const std::vector<std::string> small = {"plant",      "boxes", "bin",
                                            "floor_lamp", "crate", "stool"};
    for (int i = 0; i < 4; ++i)
      fitter_.PlaceAtWall(dice_.Pick(large), back, kNorth);
    for (int i = 0; i < 2; ++i)
      fitter_.PlaceAtWall(dice_.Pick(large), hall, kWest);
    for (int i = 0; i < 2; ++i)
      fitter_.PlaceAtWall(dice_.Pick(small), hall, kWest);
    fitter_.PlaceAtWall(dice_.Pick(small), back, kEast);
    fitter_.PlaceAtWall(dice_.Pick(large), above, kEast);
    fitter_.PlaceAtWall(dice_.Pick(small), above, kEast);
    FurnishMiddle();
    double top = frame_.depth_m;
    for (const double end : side_ends_) {
      const PlanArea room = {hall_, end, frame_.width_m, top};
      fitter_.PlaceAtWall(dice_.Chance(0.5) ? "desk" : "table", room, kEast);
      fitter_.PlaceAtWall(dice_.Pick(large), room, kEast);
      fitter_.PlaceAtWall(dice_.Pick(large), room, kNorth);
      fitter_.PlaceAtWall(dice_.Pick(small), room, kWest);
      fitter_.PlaceAtWall(dice_.Pick(small), room, kSouth);
      top = end;
    }
  }

  // Small tables with chairs, all alike, where there is room for them.
  void FurnishMiddle() {
    const int variant = 1;
    for (int i = 0; i < 10; ++i) {
      const double x = dice_.Uniform(1, hall_ - 1);
      const double y = dice_.Uniform(1.2, frame_.depth_m - 1.2);
      const bool is_below_edge = x > platform_x_ - 0.9 &&
                                 y > platform_y_ - 1.3 && y < platform_y_ + 1.2;
      if (is_below_edge || !fitter_.Place("cafe_table", x, y, 90, variant))
        continue;
      fitter_.Place("chair", x, RoundToCm(y + 0.72), 270, variant);
      fitter_.Place("chair", x, RoundToCm(y - 0.72), 90, variant);
      if (dice_.Chance(0.5))
        fitter_.Place("chair", RoundToCm(x + 0.72), y, 180, variant);
    }
  }

  // ---- walls ----

  void AddPosters() {
    for (int i = 0; i < 7; ++i) {
      fitter_.HangPoster("hall", kSouth, 0, hall_);
      fitter_.HangPoster("hall", kNorth, 0, hall_);
    }
    for (int i = 0; i < 4; ++i) {
      fitter_.HangPoster("hall", kWest, 0, frame_.depth_m);
      fitter_.HangPoster("hall", kEast, 0, frame_.depth_m);
    }
    double top = frame_.depth_m;
    for (size_t i = 0; i < side_ends_.size(); ++i) {
      const std::string room = absl::StrCat("room-", i + 1);
      for (int k = 0; k < 2; ++k) {
        fitter_.HangPoster(room, kWest, side_ends_[i], top);
        fitter_.HangPoster(room, kEast, side_ends_[i], top);
        fitter_.HangPoster(room, kNorth, hall_, frame_.width_m);
        fitter_.HangPoster(room, kSouth, hall_, frame_.width_m);
      }
      top = side_ends_[i];
    }
  }

  void AddMovers() {
    PlanMover person;
    person.name = "person";
    person.speed_mps = dice_.Uniform(0.6, 1.2);
    person.path = {{frame_.Point(approach_x_, aisle_y_), dice_.Uniform(0, 6)},
                   {frame_.Point(hall_ - 0.8, aisle_y_), dice_.Uniform(0, 6)}};
    plan_.movers.push_back(person);
  }

  PlanDice dice_;
  BuildingPlan plan_;
  PlanFrame frame_;
  PlanFitter fitter_;
  PlanLooks looks_;
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
  std::vector<std::array<double, 2>> corners_;
};

}  // namespace

BuildingPlan DrawPlan(uint64_t seed, int attempt) {
  return PlanDrawer(seed, attempt).Draw();
}

}  // namespace treeline::building

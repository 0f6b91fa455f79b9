#include "simulation/building/office_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "simulation/building/plan_fitter.h"

namespace treeline::building {
namespace {

constexpr double kHeight_m = 2.8;
constexpr double kCorridor_m = 2.2;
constexpr double kPassage_m = 1.6;
constexpr double kPassageHeight_m = 2.4;
constexpr double kDoor_m = 1;
// A room's door is so far from its corners at least.
constexpr double kBesideDoor_m = 0.9;
// How deep the tour goes into a room, as a share of its depth.
constexpr double kIntoRoom = 0.5;
constexpr double kNarrowestRoom_m = 3.6;
constexpr double kWidestRoom_m = 6.4;
constexpr double kUsualWing_m = 13;
// Of rooms that have a neighbour, so many are like it.
constexpr double kTwins = 0.3;
constexpr double kSpotEvery_m = 2.6;  // of corridor walls, for a poster

class OfficeDrawer {
 public:
  OfficeDrawer(int area_m2, uint64_t seed, int attempt)
      : dice_(base::MixBits(seed) + static_cast<uint64_t>(attempt),
              base::MixBits(static_cast<uint64_t>(area_m2))),
        fitter_(dice_, plan_, frame_) {
    plan_.seed = base::MixBits(seed + 1) >> 12;
    wings_ = std::max(
        1, static_cast<int>(std::lround(std::sqrt(area_m2) / kUsualWing_m)));
    row_m_ = dice_.Uniform(5.1, 5.7);
    wing_m_ = RoundToCm(2 * row_m_ + kCorridor_m);
    frame_.depth_m = RoundToCm(wings_ * wing_m_);
    frame_.width_m = RoundToCm(area_m2 / frame_.depth_m);
    plan_.size_m = {frame_.width_m, frame_.depth_m, kHeight_m};
  }

  BuildingPlan Draw() {
    looks_ = DrawFinishes(5, 8, dice_, plan_);
    AddCorridors();
    for (int wing = 0; wing < wings_; ++wing) {
      AddRow(wing, kSouth);
      AddRow(wing, kNorth);
    }
    AddTour();
    for (const Room& room : rooms_) Furnish(room);
    FurnishCorridors();
    AddPosters();
    AddPeople();
    return std::move(plan_);
  }

 private:
  struct Room {
    std::string name;
    PlanArea area;
    int wing = 0;
    PlanSide row = kSouth;  // of its corridor
    double door_x = 0;
    // Of a room with a twin before it: how far that is to the west.
    double twin_m = 0;

    double Width_m() const { return area.x1_m - area.x0_m; }
  };

  // The middle of a wing's corridor.
  double Aisle(int wing) const {
    return RoundToCm(wing * wing_m_ + wing_m_ / 2);
  }
  static std::string Corridor(int wing) {
    return absl::StrCat("corridor-", wing + 1);
  }

  void AddRoom(const std::string& name, const PlanArea& area, PlanLamps lamps) {
    PlanRoom room;
    room.name = name;
    room.area = area;
    room.height_m = kHeight_m;
    room.floor = dice_.Pick(looks_.floors);
    for (std::string& wall : room.walls) wall = dice_.Pick(looks_.walls);
    room.lamps = lamps;
    plan_.rooms.push_back(room);
  }

  static int LampsAlong(double length_m) {
    return std::max(1, static_cast<int>(length_m / 6));
  }

  void AddCorridors() {
    AddRoom("corridor-across", {0, 0, kCorridor_m, frame_.depth_m},
            {1, LampsAlong(frame_.depth_m)});
    for (int wing = 0; wing < wings_; ++wing) {
      const double aisle = Aisle(wing);
      AddRoom(Corridor(wing),
              {kCorridor_m, RoundToCm(aisle - kCorridor_m / 2), frame_.width_m,
               RoundToCm(aisle + kCorridor_m / 2)},
              {LampsAlong(frame_.width_m), 1});
      PlanDoor passage;
      passage.place = frame_.OnWall(Corridor(wing), kWest, aisle);
      passage.width_m = kPassage_m;
      passage.height_m = kPassageHeight_m;
      plan_.doors.push_back(passage);
      fitter_.AddWindow(frame_.OnWall(Corridor(wing), kEast, aisle));
      fitter_.AddWindow(frame_.OnWall("corridor-across", kWest,
                                      RoundToCm(aisle + wing_m_ / 4)));
    }
  }

  // The rooms on one side of a corridor, from the west.
  void AddRow(int wing, PlanSide row) {
    const double end = frame_.width_m;
    double x = kCorridor_m;
    bool has_neighbour = false;
    while (end - x > 0.01) {
      Room room;
      room.wing = wing;
      room.row = row;
      double width = dice_.Uniform(kNarrowestRoom_m, kWidestRoom_m);
      if (has_neighbour && dice_.Chance(kTwins) &&
          end - x >= rooms_.back().Width_m() + kNarrowestRoom_m) {
        width = rooms_.back().Width_m();
        room.twin_m = RoundToCm(x - rooms_.back().area.x0_m);
      } else if (end - x < width + kNarrowestRoom_m) {
        width = end - x;  // No room for another one.
      }
      const double x1 = RoundToCm(x + width);
      const double y0 = row == kSouth
                            ? RoundToCm(wing * wing_m_)
                            : RoundToCm(Aisle(wing) + kCorridor_m / 2);
      const double y1 = row == kSouth ? RoundToCm(Aisle(wing) - kCorridor_m / 2)
                                      : RoundToCm((wing + 1) * wing_m_);
      room.area = {x, y0, x1, y1};
      room.name = absl::StrCat("room-", rooms_.size() + 1);
      room.door_x = room.twin_m > 0
                        ? RoundToCm(rooms_.back().door_x + room.twin_m)
                        : dice_.Uniform(x + kBesideDoor_m, x1 - kBesideDoor_m);
      AddRoom(room.name, room.area, {room.Width_m() > 4.6 ? 2 : 1, 1});
      if (room.twin_m > 0) LookLikeTheOneBefore();
      OpenRoom(room);
      rooms_.push_back(room);
      has_neighbour = true;
      x = x1;
    }
  }

  void LookLikeTheOneBefore() {
    PlanRoom& room = plan_.rooms.back();
    const PlanRoom& twin = plan_.rooms[plan_.rooms.size() - 2];
    room.floor = twin.floor;
    room.walls = twin.walls;
  }

  void OpenRoom(const Room& room) {
    fitter_.AddDoor(
        frame_.OnWall(room.name, room.row == kSouth ? kNorth : kSouth,
                      room.door_x),
        kDoor_m, dice_.Chance(0.4) ? DoorLeaf::kOpen : DoorLeaf::kNone);
    const bool is_outside =
        room.row == kSouth ? room.wing == 0 : room.wing == wings_ - 1;
    if (is_outside) {
      fitter_.AddWindow(
          frame_.OnWall(room.name, room.row,
                        RoundToCm((room.area.x0_m + room.area.x1_m) / 2)));
    }
  }

  // Along each corridor and back, into the southern rooms on the way there,
  // into the northern ones on the way back. All of it stays free.
  void AddTour() {
    const double lobby_x = kCorridor_m / 2;
    fitter_.AddPlace("lobby", lobby_x, Aisle(0), 0);
    for (int wing = 0; wing < wings_; ++wing) {
      const double aisle = Aisle(wing);
      Walk(lobby_x, aisle);
      for (const Room& room : rooms_) {
        if (room.wing == wing && room.row == kSouth) Visit(room);
      }
      Walk(RoundToCm(frame_.width_m - 0.9), aisle);
      for (size_t i = rooms_.size(); i-- > 0;) {
        if (rooms_[i].wing == wing && rooms_[i].row == kNorth) Visit(rooms_[i]);
      }
      Walk(lobby_x, aisle);
    }
    fitter_.KeepLeg(corners_.front(), corners_.back());
  }

  void Visit(const Room& room) {
    const double depth = room.area.y1_m - room.area.y0_m;
    const double inside =
        RoundToCm(room.row == kSouth ? room.area.y1_m - kIntoRoom * depth
                                     : room.area.y0_m + kIntoRoom * depth);
    Walk(room.door_x, Aisle(room.wing));
    Walk(room.door_x, inside);
    Walk(room.door_x, Aisle(room.wing));
    fitter_.AddPlace(room.name, room.door_x, inside,
                     room.row == kSouth ? 270 : 90);
  }

  void Walk(double x, double y) {
    const std::array<double, 2> corner = {x, y};
    if (!corners_.empty()) {
      if (corners_.back() == corner) return;
      fitter_.KeepLeg(corners_.back(), corner);
    }
    corners_.push_back(corner);
    plan_.tour.push_back(frame_.Point(x, y));
  }

  void Furnish(const Room& room) {
    if (room.twin_m > 0) {
      const size_t end = plan_.furniture.size();
      for (size_t i = room_begin_; i < end; ++i) {
        const PlanFurniture piece = plan_.furniture[i];
        fitter_.Place(piece.kind, RoundToCm(piece.stand.at.x_m + room.twin_m),
                      piece.stand.at.y_m, piece.stand.facing_deg,
                      piece.variant);
      }
      room_begin_ = end;
      return;
    }
    room_begin_ = plan_.furniture.size();
    ++variant_;
    const std::vector<std::string> large = {"bookcase", "sideboard", "wardrobe",
                                            "rack",     "machine",   "sofa"};
    const std::vector<std::string> small = {"plant", "boxes", "bin",
                                            "floor_lamp", "crate"};
    const PlanSide back = room.row;
    const PlanArea& area = room.area;
    if (dice_.Chance(0.6)) {
      for (int i = 0; i < 2; ++i) FurnishDesk(area, back == kSouth);
    } else {
      FurnishTable(room);
    }
    fitter_.PlaceAtWall(dice_.Pick(large), area, back, variant_);
    fitter_.PlaceAtWall(dice_.Pick(large), area, kWest, variant_);
    fitter_.PlaceAtWall(dice_.Pick(large), area, kEast, variant_);
    fitter_.PlaceAtWall(dice_.Pick(small), area, back, variant_);
    fitter_.PlaceAtWall(dice_.Pick(small), area,
                        dice_.Chance(0.5) ? kWest : kEast, variant_);
  }

  // A desk at the back wall, and a chair before it.
  void FurnishDesk(const PlanArea& area, bool is_back_south) {
    constexpr double kFromWall_m = 0.5;
    constexpr double kToChair_m = 0.85;
    const double x = dice_.Uniform(area.x0_m + 1, area.x1_m - 1);
    const double toward = is_back_south ? 1 : -1;
    const double wall = is_back_south ? area.y0_m : area.y1_m;
    const double y = RoundToCm(wall + toward * kFromWall_m);
    const double facing = is_back_south ? 90 : 270;
    if (!fitter_.Place("desk", x, y, facing, variant_)) return;
    fitter_.Place("office_chair", x, RoundToCm(y + toward * kToChair_m),
                  is_back_south ? 270 : 90, variant_);
  }

  // A table between the way in and a side wall, with chairs around it.
  void FurnishTable(const Room& room) {
    const PlanArea& area = room.area;
    const bool is_west = room.door_x - area.x0_m > area.x1_m - room.door_x;
    const double x = RoundToCm(is_west ? area.x0_m + 1.5 : area.x1_m - 1.5);
    const double y = RoundToCm((area.y0_m + area.y1_m) / 2);
    if (!fitter_.Place("table", x, y, 90, variant_)) return;
    for (const double along : {-0.45, 0.45}) {
      fitter_.Place("chair", RoundToCm(x + along), RoundToCm(y + 0.7), 270,
                    variant_);
      fitter_.Place("chair", RoundToCm(x + along), RoundToCm(y - 0.7), 90,
                    variant_);
    }
  }

  void FurnishCorridors() {
    const std::vector<std::string> things = {"plant", "bench", "bin",
                                             "bookcase"};
    variant_ = 0;
    for (int wing = 0; wing < wings_; ++wing) {
      const PlanArea& area = plan_.rooms[1 + static_cast<size_t>(wing)].area;
      for (int i = 0; i < LampsAlong(frame_.width_m); ++i) {
        fitter_.PlaceAtWall(dice_.Pick(things), area,
                            dice_.Chance(0.5) ? kSouth : kNorth);
      }
    }
  }

  void AddPosters() {
    const auto along = [&](const std::string& room, PlanSide side, double low,
                           double high) {
      const int count = static_cast<int>((high - low) / kSpotEvery_m);
      for (int i = 0; i < count; ++i) {
        if (dice_.Chance(0.6)) fitter_.HangPoster(room, side, low, high);
      }
    };
    for (int wing = 0; wing < wings_; ++wing) {
      along(Corridor(wing), kSouth, kCorridor_m, frame_.width_m);
      along(Corridor(wing), kNorth, kCorridor_m, frame_.width_m);
    }
    along("corridor-across", kWest, 0, frame_.depth_m);
    for (const Room& room : rooms_) {
      const PlanArea& area = room.area;
      along(room.name, room.row, area.x0_m, area.x1_m);
      along(room.name, kWest, area.y0_m, area.y1_m);
      along(room.name, kEast, area.y0_m, area.y1_m);
    }
  }

  // One in each corridor, there and back.
  void AddPeople() {
    for (int wing = 0; wing < wings_; ++wing) {
      PlanMover person;
      person.name = absl::StrCat("person-", wing + 1);
      person.speed_mps = dice_.Uniform(0.6, 1.2);
      const double aisle = Aisle(wing);
      person.path = {
          {frame_.Point(kCorridor_m + 0.8, aisle), dice_.Uniform(0, 6)},
          {frame_.Point(frame_.width_m - 1.2, aisle), dice_.Uniform(0, 6)}};
      plan_.movers.push_back(person);
    }
  }

  PlanDice dice_;
  BuildingPlan plan_;
  PlanFrame frame_;
  PlanFitter fitter_;
  PlanLooks looks_;
  int wings_ = 1;
  double row_m_ = 0;   // how deep rooms are
  double wing_m_ = 0;  // two rows and a corridor
  std::vector<Room> rooms_;
  std::vector<std::array<double, 2>> corners_;
  int variant_ = 0;        // of this room's furniture
  size_t room_begin_ = 0;  // where it begins
};

}  // namespace

BuildingPlan DrawOffice(int area_m2, uint64_t seed, int attempt) {
  return OfficeDrawer(area_m2, seed, attempt).Draw();
}

}  // namespace treeline::building

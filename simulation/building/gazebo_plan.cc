#include "simulation/building/gazebo_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/building/field_hall.h"
#include "simulation/building/read_values.h"

namespace treeline::building {
namespace {

// From here on nothing is in a robot's way.
constexpr double kOverhead_m = 2;
// What is lower is no obstacle.
constexpr double kFlat_m = 0.02;
// What begins lower stands on the ground.
constexpr double kHovers_m = 0.1;
// Higher ones are as high as this.
constexpr double kHighest_m = 19;
// Of the hall, and between things and its ceiling.
constexpr double kLeastHeight_m = 3;
constexpr double kAbove_m = 0.5;
// Between everything and the hall's walls: what lasers do not see.
constexpr double kBeyondLasers_m = 31;
constexpr double kLeastMargin_m = 2;
// What a plan can say; thinner ones are so thick.
constexpr double kLeastLength_m = 0.06;
constexpr double kLeastThickness_m = 0.01;
constexpr double kLeastPillar_m = 0.02;
// Of a place to start: how far it is looked for, how densely, and how much room
// is enough, or just enough.
constexpr double kSearch_m = 20;
constexpr double kSearchStep_m = 0.25;
constexpr double kRoom_m = 1.5;
constexpr double kLeastRoom_m = 0.5;
constexpr size_t kShownModelChars = 60;

double HalfDiagonal_m(const GazeboSolid& solid) {
  return solid.is_round ? solid.along_m / 2
                        : std::hypot(solid.along_m, solid.across_m) / 2;
}

double Distance_m(const GazeboSolid& solid, double x_m, double y_m) {
  const double dx = x_m - solid.x_m;
  const double dy = y_m - solid.y_m;
  if (solid.is_round) return std::hypot(dx, dy) - solid.along_m / 2;
  const double c = std::cos(solid.yaw_rad);
  const double s = std::sin(solid.yaw_rad);
  return std::hypot(
      std::max(0.0, std::abs(c * dx + s * dy) - solid.along_m / 2),
      std::max(0.0, std::abs(c * dy - s * dx) - solid.across_m / 2));
}

absl::Status Refused(const GazeboSolid& solid, absl::string_view name,
                     absl::string_view reason) {
  return absl::InvalidArgumentError(
      absl::StrCat(name, ":", solid.line, ": model '",
                   solid.model.substr(0, kShownModelChars), "': ", reason));
}

absl::StatusOr<std::vector<GazeboSolid>> InTheWay(
    const std::vector<GazeboSolid>& solids, absl::string_view name) {
  std::vector<GazeboSolid> kept;
  for (const GazeboSolid& solid : solids) {
    if (solid.bottom_m >= kOverhead_m || solid.top_m < kFlat_m) continue;
    if (solid.bottom_m > kHovers_m) {
      return Refused(
          solid, name,
          absl::StrCat("it begins ", ToMillimetres(solid.bottom_m),
                       " m above the ground; what stands on it is read"));
    }
    kept.push_back(solid);
  }
  return kept;
}

// The lower corner of the hall in Gazebo's world, and its measures.
struct Hall {
  double x0_m = 0;
  double y0_m = 0;
  double width_m = 0;
  double depth_m = 0;

  PlanPoint At(double x_m, double y_m) const {
    return {ToMillimetres(x_m - x0_m), ToMillimetres(y_m - y0_m), {}};
  }
};

absl::StatusOr<Hall> HallAround(const std::vector<GazeboSolid>& solids,
                                absl::string_view name) {
  Hall hall;
  double x1_m = 0;
  double y1_m = 0;
  for (const GazeboSolid& solid : solids) {
    const double reach_m = HalfDiagonal_m(solid);
    hall.x0_m = std::min(hall.x0_m, solid.x_m - reach_m);
    hall.y0_m = std::min(hall.y0_m, solid.y_m - reach_m);
    x1_m = std::max(x1_m, solid.x_m + reach_m);
    y1_m = std::max(y1_m, solid.y_m + reach_m);
    if (std::max(x1_m - hall.x0_m, y1_m - hall.y0_m) >
        kMaxSize_m - 2 * kLeastMargin_m) {
      return Refused(solid, name,
                     absl::StrCat("with it the world is larger than ",
                                  kMaxSize_m - 2 * kLeastMargin_m, " m"));
    }
  }
  const double largest_m = std::max(x1_m - hall.x0_m, y1_m - hall.y0_m);
  const double margin_m =
      std::min(kBeyondLasers_m, (kMaxSize_m - largest_m) / 2);
  hall.x0_m = ToMillimetres(hall.x0_m - margin_m);
  hall.y0_m = ToMillimetres(hall.y0_m - margin_m);
  hall.width_m =
      std::min(kMaxSize_m, ToMillimetres(x1_m + margin_m - hall.x0_m));
  hall.depth_m =
      std::min(kMaxSize_m, ToMillimetres(y1_m + margin_m - hall.y0_m));
  return hall;
}

double Height_m(const GazeboSolid& solid) {
  return ToMillimetres(std::min(solid.top_m, kHighest_m));
}

PlanPillar PillarOf(const GazeboSolid& solid, const Hall& hall) {
  PlanPillar pillar;
  pillar.at = hall.At(solid.x_m, solid.y_m);
  pillar.width_m = ToMillimetres(std::max(solid.along_m, kLeastPillar_m));
  pillar.is_round = true;
  pillar.height_m = Height_m(solid);
  return pillar;
}

PlanWall WallOf(const GazeboSolid& solid, const Hall& hall, size_t number) {
  const bool is_turned = solid.across_m > solid.along_m;
  const double yaw_rad = solid.yaw_rad + (is_turned ? std::numbers::pi / 2 : 0);
  const double half_m =
      std::max({solid.along_m, solid.across_m, kLeastLength_m}) / 2;
  const double dx = half_m * std::cos(yaw_rad);
  const double dy = half_m * std::sin(yaw_rad);
  PlanWall wall;
  wall.name = absl::StrCat("box-", number + 1);
  wall.from = hall.At(solid.x_m - dx, solid.y_m - dy);
  wall.from.z_m = 0;
  wall.to = hall.At(solid.x_m + dx, solid.y_m + dy);
  wall.height_m = Height_m(solid);
  wall.thickness_m = ToMillimetres(
      std::max(std::min(solid.along_m, solid.across_m), kLeastThickness_m));
  wall.finish = "white";
  return wall;
}

// Where a robot has room, and how much.
struct Spot {
  double x_m = 0;
  double y_m = 0;
  double room_m = 0;
};

Spot NearestSpot(const std::vector<GazeboSolid>& solids, const Hall& hall) {
  const int reach = static_cast<int>(kSearch_m / kSearchStep_m);
  std::vector<Spot> spots;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      spots.push_back({i * kSearchStep_m, j * kSearchStep_m, 0});
    }
  }
  std::ranges::stable_sort(spots, {}, [](const Spot& spot) {
    return std::hypot(spot.x_m, spot.y_m);
  });
  Spot best;
  for (Spot& spot : spots) {
    spot.room_m = std::min({spot.x_m - hall.x0_m, spot.y_m - hall.y0_m,
                            hall.x0_m + hall.width_m - spot.x_m,
                            hall.y0_m + hall.depth_m - spot.y_m, kRoom_m});
    for (const GazeboSolid& solid : solids) {
      if (spot.room_m <= best.room_m) break;
      spot.room_m =
          std::min(spot.room_m, Distance_m(solid, spot.x_m, spot.y_m));
    }
    if (spot.room_m > best.room_m) best = spot;
    if (best.room_m >= kRoom_m) break;
  }
  return best;
}

}  // namespace

absl::StatusOr<BuildingPlan> GazeboPlan(const std::vector<GazeboSolid>& solids,
                                        absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const std::vector<GazeboSolid> things,
                      InTheWay(solids, name));
  TL_ASSIGN_OR_RETURN(const Hall hall, HallAround(things, name));
  BuildingPlan plan;
  // Maps of the whole of it are made: no higher than need be.
  double height_m = kLeastHeight_m;
  for (const GazeboSolid& solid : things) {
    height_m = std::max(height_m, Height_m(solid) + kAbove_m);
  }
  plan.size_m = {hall.width_m, hall.depth_m, height_m};
  PlanRoom room;
  room.name = "ground";
  room.area = {0, 0, hall.width_m, hall.depth_m};
  room.height_m = height_m;
  room.floor = "concrete";
  room.walls.fill("white");
  plan.rooms.push_back(room);
  for (const GazeboSolid& solid : things) {
    if (solid.is_round) {
      plan.pillars.push_back(PillarOf(solid, hall));
    } else {
      plan.walls.push_back(WallOf(solid, hall, plan.walls.size()));
    }
    if (std::max(plan.pillars.size(), plan.walls.size()) > kMaxPillars) {
      return Refused(
          solid, name,
          absl::StrCat("more than ", kMaxPillars, " boxes or cylinders"));
    }
  }
  const Spot spot = NearestSpot(things, hall);
  if (spot.room_m < kLeastRoom_m) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": nowhere within ", kSearch_m,
                     " m of the origin has a robot room"));
  }
  plan.places = {
      {.name = "start",
       .stand = {.at = hall.At(spot.x_m, spot.y_m), .facing_deg = 0}},
      {.name = std::string(kGazeboOrigin),
       .stand = {.at = hall.At(0, 0), .facing_deg = 0}}};
  plan.tour = {hall.At(spot.x_m, spot.y_m),
               hall.At(spot.x_m + spot.room_m / 2, spot.y_m),
               hall.At(spot.x_m, spot.y_m + spot.room_m / 2)};
  return plan;
}

}  // namespace treeline::building

#include "simulation/building/plan_geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace treeline::building {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNear_m = 1e-6;
constexpr double kSameGround_m = 0.1;
constexpr absl::string_view kSides[] = {".south", ".east", ".north", ".west"};

// Ground, and how far down it is solid.
struct Ground {
  double height_m = 0;
  double solid_from_m = 0;
};

std::optional<double> RampHeightAt(const PlanRamp& ramp, double x_m,
                                   double y_m) {
  const double dx = ramp.to.x_m - ramp.from.x_m;
  const double dy = ramp.to.y_m - ramp.from.y_m;
  const double run = std::hypot(dx, dy);
  const double along =
      ((x_m - ramp.from.x_m) * dx + (y_m - ramp.from.y_m) * dy) / run;
  const double across =
      ((y_m - ramp.from.y_m) * dx - (x_m - ramp.from.x_m) * dy) / run;
  if (along < 0 || along > run || 2 * std::abs(across) > ramp.width_m) {
    return std::nullopt;
  }
  const double low = ramp.from.z_m.value_or(0);
  return low + (ramp.to.z_m.value_or(0) - low) * along / run;
}

std::vector<Ground> GroundsAt(const BuildingPlan& plan, double x, double y) {
  std::vector<Ground> grounds;
  for (const PlanRoom& room : plan.rooms) {
    if (room.area.Contains(x, y)) grounds.push_back({room.base_m, room.base_m});
  }
  for (const PlanPlatform& platform : plan.platforms) {
    if (!platform.area.Contains(x, y)) continue;
    grounds.push_back(
        {platform.height_m, platform.thickness_m > 0
                                ? platform.height_m - platform.thickness_m
                                : platform.base_m});
  }
  for (const PlanRamp& ramp : plan.ramps) {
    if (const auto height = RampHeightAt(ramp, x, y)) {
      grounds.push_back({*height, ramp.base_m});
    }
  }
  return grounds;
}

const PlanArea& AreaOf(const BuildingPlan& plan, const WallRef& ref) {
  return plan.rooms[static_cast<size_t>(ref.room)].area;
}

bool RunsAlongX(PlanSide side) { return side == kSouth || side == kNorth; }

// The coordinate that is the same all along a side.
double LineOf(const PlanArea& area, PlanSide side) {
  switch (side) {
    case kSouth:
      return area.y0_m;
    case kEast:
      return area.x1_m;
    case kNorth:
      return area.y1_m;
    case kWest:
      return area.x0_m;
  }
  return 0;
}

WallRef RoomSide(const BuildingPlan& plan, size_t room, PlanSide side) {
  const PlanRoom& of = plan.rooms[room];
  WallRef ref;
  ref.room = static_cast<int>(room);
  ref.side = side;
  ref.low_m = RunsAlongX(side) ? of.area.x0_m : of.area.y0_m;
  ref.high_m = RunsAlongX(side) ? of.area.x1_m : of.area.y1_m;
  ref.base_m = of.base_m;
  ref.height_m = of.height_m;
  return ref;
}

}  // namespace

double PlanRamp::Slope() const {
  return (to.z_m.value_or(0) - from.z_m.value_or(0)) /
         std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
}

std::optional<double> GroundAt(const BuildingPlan& plan,
                               const PlanPoint& point) {
  const std::vector<Ground> grounds = GroundsAt(plan, point.x_m, point.y_m);
  std::optional<double> best;
  for (const Ground& ground : grounds) {
    const bool is_buried =
        std::any_of(grounds.begin(), grounds.end(), [&](const Ground& other) {
          return other.height_m > ground.height_m + kNear_m &&
                 other.solid_from_m <= ground.height_m + kNear_m;
        });
    if (is_buried) continue;
    if (point.z_m.has_value()) {
      const double off = std::abs(ground.height_m - *point.z_m);
      if (off > kSameGround_m) continue;
      if (!best || off < std::abs(*best - *point.z_m)) best = ground.height_m;
    } else if (!best || ground.height_m < *best) {
      best = ground.height_m;
    }
  }
  return best;
}

std::optional<WallRef> FindWall(const BuildingPlan& plan,
                                absl::string_view name) {
  for (size_t i = 0; i < plan.rooms.size(); ++i) {
    for (const PlanSide side : {kSouth, kEast, kNorth, kWest}) {
      if (name == absl::StrCat(plan.rooms[i].name, kSides[side])) {
        return RoomSide(plan, i, side);
      }
    }
  }
  for (size_t i = 0; i < plan.walls.size(); ++i) {
    const PlanWall& wall = plan.walls[i];
    absl::string_view rest = name;
    if (!absl::ConsumePrefix(&rest, wall.name)) continue;
    if (!rest.empty() && rest != ".left" && rest != ".right") continue;
    WallRef ref;
    ref.wall = static_cast<int>(i);
    ref.is_left = rest != ".right";
    ref.names_side = !rest.empty();
    ref.high_m =
        std::hypot(wall.to.x_m - wall.from.x_m, wall.to.y_m - wall.from.y_m);
    ref.base_m = wall.from.z_m.value_or(0);
    ref.height_m = wall.height_m;
    return ref;
  }
  return std::nullopt;
}

std::vector<std::string> WallNames(const BuildingPlan& plan) {
  std::vector<std::string> names;
  for (const PlanRoom& room : plan.rooms) {
    for (const absl::string_view side : kSides) {
      names.push_back(absl::StrCat(room.name, side));
    }
  }
  for (const PlanWall& wall : plan.walls) names.push_back(wall.name);
  return names;
}

std::optional<WallRef> WallBehind(const BuildingPlan& plan, const WallRef& ref,
                                  double at0_m, double at1_m) {
  if (ref.room < 0) return std::nullopt;
  const PlanSide opposite = static_cast<PlanSide>((ref.side + 2) % 4);
  const double line = LineOf(AreaOf(plan, ref), ref.side);
  for (size_t i = 0; i < plan.rooms.size(); ++i) {
    const WallRef other = RoomSide(plan, i, opposite);
    if (std::abs(LineOf(plan.rooms[i].area, opposite) - line) < kNear_m &&
        other.low_m <= at0_m && other.high_m >= at1_m &&
        std::abs(other.base_m - ref.base_m) < kNear_m) {
      return other;
    }
  }
  return std::nullopt;
}

WallFrame FrameOnWall(const BuildingPlan& plan, const WallRef& ref,
                      double at_m) {
  if (ref.room >= 0) {
    const double line = LineOf(AreaOf(plan, ref), ref.side);
    const double half = kRoomWall_m / 2;
    switch (ref.side) {
      case kSouth:
        return {at_m, line + half, 0};
      case kEast:
        return {line - half, at_m, kPi / 2};
      case kNorth:
        return {at_m, line - half, kPi};
      case kWest:
        return {line + half, at_m, 1.5 * kPi};
    }
  }
  const PlanWall& wall = plan.walls[static_cast<size_t>(ref.wall)];
  const double heading =
      std::atan2(wall.to.y_m - wall.from.y_m, wall.to.x_m - wall.from.x_m);
  const double half = (ref.is_left ? 0.5 : -0.5) * wall.thickness_m;
  return {wall.from.x_m + std::cos(heading) * at_m - std::sin(heading) * half,
          wall.from.y_m + std::sin(heading) * at_m + std::cos(heading) * half,
          ref.is_left ? heading : heading + kPi};
}

}  // namespace treeline::building

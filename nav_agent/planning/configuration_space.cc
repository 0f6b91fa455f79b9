#include "nav_agent/planning/configuration_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

// Room beside is known so finely (m).
constexpr double kRoomStep_m = 0.004;

bool DiscTouches(const Disc& disc, const OrientedBox& box) {
  const geometry::Vec2 from_origin = disc.center - box.origin;
  const double x = box.cos_yaw * from_origin.x + box.sin_yaw * from_origin.y;
  const double y = -box.sin_yaw * from_origin.x + box.cos_yaw * from_origin.y;
  const double dx = x - std::clamp(x, box.back_m, box.front_m);
  const double dy = y - std::clamp(y, -box.half_width_m, box.half_width_m);
  return dx * dx + dy * dy < disc.radius_m * disc.radius_m;
}

}  // namespace

Footprint Footprint::Of(const core::RobotModel& robot, double margin_m) {
  const double front_m = robot.front_m + margin_m;
  const double rear_m = robot.rear_m + margin_m;
  const double half_width_m = robot.half_width_m + margin_m;
  return {.front_m = front_m,
          .rear_m = rear_m,
          .half_width_m = half_width_m,
          .circumradius_m = std::hypot(std::max(front_m, rear_m), half_width_m),
          .inscribed_m = std::min({front_m, rear_m, half_width_m})};
}

ConfigurationSpace::ConfigurationSpace(
    std::shared_ptr<const GroundIndex> ground, const Footprint& footprint,
    std::vector<Disc> discs)
    : ground_(std::move(ground)),
      footprint_(footprint),
      discs_(std::move(discs)) {}

OrientedBox ConfigurationSpace::BoxAt(geometry::Vec2 at, double yaw_rad) const {
  return {.origin = at,
          .cos_yaw = std::cos(yaw_rad),
          .sin_yaw = std::sin(yaw_rad),
          .back_m = -footprint_.rear_m,
          .front_m = footprint_.front_m,
          .half_width_m = footprint_.half_width_m};
}

bool ConfigurationSpace::BoxIsFree(int level, const OrientedBox& box) const {
  for (const Disc& disc : discs_) {
    if (disc.level == level && DiscTouches(disc, box)) return false;
  }
  return ground_->IsFree(level, box);
}

double ConfigurationSpace::RoomAtLeast_m(const Spot& spot) const {
  const core::CellIndex cell = ground_->CellOf(spot.at);
  // From the centre to the spot, and from the middle of what is blocked to its
  // corner.
  double room_m = ground_->Clearance_m(spot.level, cell) -
                  geometry::Norm(spot.at - ground_->CenterOf(cell)) -
                  ground_->resolution_m() * std::numbers::sqrt2 / 2;
  for (const Disc& disc : discs_) {
    if (disc.level != spot.level) continue;
    room_m =
        std::min(room_m, geometry::Norm(spot.at - disc.center) - disc.radius_m);
  }
  return std::max(0.0, room_m);
}

bool ConfigurationSpace::Fits(const Spot& spot, double yaw_rad) const {
  const core::CellIndex cell = ground_->CellOf(spot.at);
  if (!ground_->Contains(cell) || !ground_->map().IsFree(spot.level, cell)) {
    return false;
  }
  if (RoomAtLeast_m(spot) >= footprint_.circumradius_m) return true;
  // The nearest blocked centre lies within the inscribed disc.
  if (ground_->Clearance_m(spot.level, cell) +
          geometry::Norm(spot.at - ground_->CenterOf(cell)) <
      footprint_.inscribed_m) {
    return false;
  }
  return BoxIsFree(spot.level, BoxAt(spot.at, yaw_rad));
}

bool ConfigurationSpace::FitsTurning(const Spot& spot) const {
  const core::CellIndex cell = ground_->CellOf(spot.at);
  if (spot.level < 0 || spot.level >= ground_->levels() ||
      !ground_->Contains(cell) || !ground_->map().IsFree(spot.level, cell)) {
    return false;
  }
  const double radius_m = footprint_.circumradius_m;
  if (RoomAtLeast_m(spot) >= radius_m) return true;
  for (const Disc& disc : discs_) {
    if (disc.level == spot.level &&
        geometry::Norm(disc.center - spot.at) < disc.radius_m + radius_m) {
      return false;
    }
  }
  return ground_->IsFreeDisc(spot.level, spot.at, radius_m);
}

bool ConfigurationSpace::MayHoldDisc(const Spot& spot) const {
  const core::CellIndex cell = ground_->CellOf(spot.at);
  if (!ground_->Contains(cell) ||
      ground_->Clearance_m(spot.level, cell) <
          ground_->NeededClearance_m(footprint_.inscribed_m)) {
    return false;
  }
  const geometry::Vec2 center = ground_->CenterOf(cell);
  const double diagonal_m = ground_->resolution_m() * std::numbers::sqrt2;
  return std::ranges::none_of(discs_, [&](const Disc& disc) {
    return disc.level == spot.level &&
           geometry::Norm(center - disc.center) + diagonal_m / 2 <
               disc.radius_m + footprint_.inscribed_m;
  });
}

double ConfigurationSpace::RoomBeside_m(const Spot& spot, double yaw_rad,
                                        int side, double reach_m) const {
  const OrientedBox middle = BoxAt(spot.at, yaw_rad);
  const geometry::Vec2 aside = {-side * middle.sin_yaw, side * middle.cos_yaw};
  double room_m = 0;
  for (double step_m = reach_m; step_m > kRoomStep_m; step_m /= 2) {
    const double wide_m = std::min(reach_m, room_m + step_m);
    OrientedBox box = middle;
    box.origin = spot.at + (wide_m / 2) * aside;
    box.half_width_m = wide_m / 2;
    if (BoxIsFree(spot.level, box)) room_m = wide_m;
  }
  return room_m;
}

bool ConfigurationSpace::CanTurn(const Spot& spot, double from_yaw_rad,
                                 double to_yaw_rad) const {
  const double turn_rad =
      geometry::NormalizedAngle_rad(to_yaw_rad - from_yaw_rad);
  if (std::abs(turn_rad) < 1e-9) return true;
  if (RoomAtLeast_m(spot) >= footprint_.circumradius_m) return true;
  const int steps = static_cast<int>(
      std::ceil(std::abs(turn_rad) * footprint_.circumradius_m /
                (kTurnStep * ground_->resolution_m())));
  const double step_rad = turn_rad / steps;
  // What a corner moves by between the headings that are looked at.
  const double grown_m = footprint_.circumradius_m * std::abs(step_rad) / 2;
  for (int i = 0; i < steps; ++i) {
    OrientedBox box = BoxAt(spot.at, from_yaw_rad + (i + 0.5) * step_rad);
    box.back_m -= grown_m;
    box.front_m += grown_m;
    box.half_width_m += grown_m;
    // Grown boxes reach beyond the disc that the corners sweep.
    if (!BoxIsFree(spot.level, box)) return FitsTurning(spot);
  }
  return true;
}

bool ConfigurationSpace::MayHead(const Spot& from, geometry::Vec2 to,
                                 geometry::Vec2 heading) const {
  const geometry::Vec2 way = to - from.at;
  const int steps =
      std::max(1, static_cast<int>(std::ceil(geometry::Norm(way) /
                                             (0.5 * ground_->resolution_m()))));
  int level = from.level;
  core::CellIndex cell = ground_->CellOf(from.at);
  for (int i = 0; i <= steps; ++i) {
    const core::CellIndex next =
        ground_->CellOf(from.at + (static_cast<double>(i) / steps) * way);
    if (next == cell && i > 0) continue;
    level = ground_->LevelAfter(level, cell, next);
    if (level < 0 || ground_->ForbidsHeading(level, next, heading)) {
      return false;
    }
    cell = next;
  }
  return true;
}

std::optional<Spot> ConfigurationSpace::Drive(const Spot& from,
                                              geometry::Vec2 to,
                                              bool looks_back) const {
  const geometry::Vec2 way = to - from.at;
  const double length_m = geometry::Norm(way);
  if (!(length_m > 1e-9)) return from;
  const double behind_m = looks_back ? footprint_.front_m : footprint_.rear_m;
  const double before_m = looks_back ? footprint_.rear_m : footprint_.front_m;
  OrientedBox box = {.origin = from.at,
                     .cos_yaw = way.x / length_m,
                     .sin_yaw = way.y / length_m,
                     .back_m = -behind_m,
                     .front_m = length_m + before_m,
                     .half_width_m = footprint_.half_width_m};
  core::CellIndex cell = ground_->CellOf(from.at);
  if (!ground_->Contains(cell) || !ground_->map().IsFree(from.level, cell)) {
    return std::nullopt;
  }
  if (ground_->has_one_way()) {
    const double sign = looks_back ? -1 : 1;
    const geometry::Vec2 heading = (sign / length_m) * way;
    if (!MayHead(from, to, heading)) return std::nullopt;
  }
  if (ground_->IsOfOneLevel(from.level, box)) {
    if (!BoxIsFree(from.level, box)) return std::nullopt;
    return Spot{to, from.level};
  }
  // Each level's part of the line is swept on that level.
  Spot at = from;
  const int steps = std::max(
      1,
      static_cast<int>(std::ceil(length_m / (0.5 * ground_->resolution_m()))));
  for (int i = 1; i <= steps; ++i) {
    const double along_m = length_m * i / steps;
    const core::CellIndex next =
        ground_->CellOf(from.at + (along_m / length_m) * way);
    if (next == cell) continue;
    const int level = ground_->LevelAfter(at.level, cell, next);
    if (level < 0) return std::nullopt;
    if (level != at.level) {
      OrientedBox part = box;
      part.front_m = along_m + before_m;
      if (!BoxIsFree(at.level, part)) return std::nullopt;
      box.back_m = along_m - behind_m;
      at.level = level;
    }
    cell = next;
  }
  if (!BoxIsFree(at.level, box)) return std::nullopt;
  at.at = to;
  return at;
}

std::optional<Spot> ConfigurationSpace::Follow(const Spot& from,
                                               geometry::Vec2 to) const {
  Spot at = {to, from.level};
  if (ground_->levels() == 1) return at;
  const geometry::Vec2 way = to - from.at;
  const int steps =
      std::max(1, static_cast<int>(std::ceil(geometry::Norm(way) /
                                             (0.5 * ground_->resolution_m()))));
  core::CellIndex cell = ground_->CellOf(from.at);
  for (int i = 1; i <= steps; ++i) {
    const core::CellIndex next =
        ground_->CellOf(from.at + (static_cast<double>(i) / steps) * way);
    if (next == cell) continue;
    at.level = ground_->LevelAfter(at.level, cell, next);
    if (at.level < 0) return std::nullopt;
    cell = next;
  }
  return at;
}

double ConfigurationSpace::CostPerMetre(const Spot& spot) const {
  const core::CellIndex cell = ground_->CellOf(spot.at);
  double room_m = ground_->Clearance_m(spot.level, cell);
  for (const Disc& disc : discs_) {
    if (disc.level != spot.level) continue;
    room_m =
        std::min(room_m, geometry::Norm(spot.at - disc.center) - disc.radius_m);
  }
  const double comfort_m = footprint_.circumradius_m + kComfort_m;
  const double lack = std::clamp(
      (comfort_m - room_m) / (comfort_m - footprint_.inscribed_m), 0.0, 1.0);
  return 1 + prices_.near * lack * lack +
         prices_.slope * ground_->SlopeSine(spot.level, cell);
}

ConfigurationSpace ConfigurationSpace::WithPrices(
    const WayPrices& prices) const {
  ConfigurationSpace other = *this;
  other.prices_ = prices;
  return other;
}

double ConfigurationSpace::LineCost_m(const Spot& from, const Spot& to) const {
  const geometry::Vec2 way = to.at - from.at;
  const double length_m = geometry::Norm(way);
  if (!(prices_.near > 0 || prices_.slope > 0)) return length_m;
  const int steps =
      std::max(1, static_cast<int>(std::ceil(length_m / kWayStep_m)));
  Spot at = from;
  core::CellIndex cell = ground_->CellOf(from.at);
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    at.at = from.at + ((i + 0.5) / steps) * way;
    if (ground_->levels() > 1) {
      const core::CellIndex next = ground_->CellOf(at.at);
      const int level = ground_->LevelAfter(at.level, cell, next);
      at.level = level < 0 ? to.level : level;
      cell = next;
    }
    sum += CostPerMetre(at);
  }
  return sum * length_m / steps;
}

}  // namespace treeline::planning

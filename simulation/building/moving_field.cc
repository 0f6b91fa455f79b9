#include "simulation/building/moving_field.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "simulation/building/field_hall.h"

namespace treeline::building {
namespace {

constexpr uint64_t kStream = 0xd1ba;
constexpr double kHalf_m = MovingField::kHalf_m;
// Crossings of the field's border are found so exactly.
constexpr double kScan_m = 0.02;
// Of the hall around it: the start is 1 m before the field.
constexpr double kHallWidth_m = 22;
constexpr double kHallDepth_m = 25;
constexpr double kFront_m = 4;
constexpr double kStartBefore_m = 1;
constexpr double kWallThickness_m = 0.5;
constexpr double kHeight_m = 1;

// What a cylinder's motion is drawn from.
struct MotionKind {
  int least_degree;
  int highest_degree;
  double slowest_mps;
  double fastest_mps;
  double least_deviation_mps;
  double most_deviation_mps;
};
constexpr MotionKind kEasyMotion = {1, 2, 0.5, 1.0, 0.01, 0.1};
constexpr MotionKind kHardMotion = {3, 4, 1.0, 2.0, 0.1, 0.2};

int DrawBetween(int low, int high, base::Random& random) {
  return low + static_cast<int>(
                   random.NextBelow(static_cast<uint32_t>(high - low) + 1));
}

// The polynomial through the points (Lagrange).
double Through(const std::vector<PlanPoint>& points, double x) {
  double y = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    double term = points[i].y_m;
    for (size_t j = 0; j < points.size(); ++j) {
      if (j == i) continue;
      term *= (x - points[j].x_m) / (points[i].x_m - points[j].x_m);
    }
    y += term;
  }
  return y;
}

// Points of whole metres, no two above each other.
std::vector<PlanPoint> DrawSupport(int degree, base::Random& random) {
  const auto coordinate = [&] {
    return static_cast<double>(DrawBetween(static_cast<int>(-kHalf_m),
                                           static_cast<int>(kHalf_m), random));
  };
  std::vector<PlanPoint> points;
  while (static_cast<int>(points.size()) <= degree) {
    const PlanPoint point = {coordinate(), coordinate(), {}};
    if (std::ranges::none_of(points,
                             [&](PlanPoint p) { return p.x_m == point.x_m; })) {
      points.push_back(point);
    }
  }
  return points;
}

// At each whole x of the field, and where the curve comes in or goes out.
std::vector<PlanPoint> PointsWithin(const std::vector<PlanPoint>& support) {
  std::vector<PlanPoint> points;
  const int steps = static_cast<int>(2 * kHalf_m / kScan_m);
  const int each = static_cast<int>(1 / kScan_m);
  bool was_inside = false;
  PlanPoint before;
  for (int i = 0; i <= steps; ++i) {
    const double x = -kHalf_m + i * kScan_m;
    const PlanPoint at = {x, Through(support, x), {}};
    const bool is_inside = std::abs(at.y_m) <= kHalf_m;
    if (i > 0 && is_inside != was_inside) {
      const PlanPoint inside = is_inside ? at : before;
      points.push_back({inside.x_m, std::copysign(kHalf_m, inside.y_m), {}});
    } else if (is_inside && i % each == 0) {
      points.push_back(at);
    }
    was_inside = is_inside;
    before = at;
  }
  return points;
}

MovingCylinder DrawCylinder(const MotionKind& kind, base::Random& random) {
  MovingCylinder cylinder;
  while (cylinder.points.size() < 2) {
    cylinder.points = PointsWithin(DrawSupport(
        DrawBetween(kind.least_degree, kind.highest_degree, random), random));
  }
  if (random.NextBelow(2) == 0) std::ranges::reverse(cylinder.points);
  const double mean_mps =
      random.NextUniform(kind.slowest_mps, kind.fastest_mps);
  const double deviation_mps =
      random.NextUniform(kind.least_deviation_mps, kind.most_deviation_mps);
  for (size_t i = 1; i < cylinder.points.size(); ++i) {
    cylinder.speeds_mps.push_back(
        std::clamp(mean_mps + deviation_mps * random.NextGaussian(),
                   kind.slowest_mps, kind.fastest_mps));
  }
  cylinder.first = static_cast<int>(
      random.NextBelow(static_cast<uint32_t>(cylinder.points.size())));
  return cylinder;
}

PlanMover MoverOf(const MovingCylinder& cylinder, size_t number) {
  PlanMover mover;
  mover.name = absl::StrCat("cylinder-", number + 1);
  mover.kind = MoverKind::kPost;
  mover.width_m = 2 * MovingField::kRadius_m;
  mover.height_m = kHeight_m;
  const size_t count = cylinder.points.size();
  for (size_t i = 0; i < count; ++i) {
    const size_t at = (static_cast<size_t>(cylinder.first) + i) % count;
    PlanMover::Stop stop;
    stop.at = {ToMillimetres(kHallWidth_m / 2 + cylinder.points[at].x_m),
               ToMillimetres(kFront_m + kHalf_m + cylinder.points[at].y_m),
               {}};
    stop.jumps = at + 1 == count;
    stop.speed_mps = stop.jumps ? 0 : ToMillimetres(cylinder.speeds_mps[at]);
    mover.path.push_back(stop);
  }
  return mover;
}

}  // namespace

MovingField DrawMovingField(uint64_t seed) {
  MovingField field;
  field.seed = seed;
  base::Random random(seed, kStream);
  // 1, 4, 7 ... are easy.
  const auto kind = static_cast<int>((seed + 2) % 3);
  field.difficulty = static_cast<FieldDifficulty>(kind);
  // Of medium ones half have few that move hard, half many that move easily.
  const bool is_hard_motion =
      field.difficulty == FieldDifficulty::kHard ||
      (field.difficulty == FieldDifficulty::kMedium && seed / 3 % 2 == 0);
  const bool has_many =
      field.difficulty == FieldDifficulty::kHard ||
      (field.difficulty == FieldDifficulty::kMedium && !is_hard_motion);
  const int count =
      has_many ? DrawBetween(10, 20, random) : DrawBetween(5, 10, random);
  for (int i = 0; i < count; ++i) {
    field.cylinders.push_back(
        DrawCylinder(is_hard_motion ? kHardMotion : kEasyMotion, random));
  }
  return field;
}

BuildingPlan MovingFieldPlan(const MovingField& field) {
  BuildingPlan plan = PlanOf(FieldHall{.width_m = kHallWidth_m,
                                       .depth_m = kHallDepth_m,
                                       .lamps = {3, 3},
                                       .start_y_m = kFront_m - kStartBefore_m,
                                       .goal_ahead_m = kMovingFieldGoalAhead_m},
                             field.seed);
  const double left_m = kHallWidth_m / 2 - kHalf_m;
  const double right_m = kHallWidth_m / 2 + kHalf_m;
  const double back_m = kFront_m + 2 * kHalf_m;
  const auto add_wall = [&](std::string name, PlanPoint from, PlanPoint to) {
    plan.walls.push_back({.name = std::move(name),
                          .from = from,
                          .to = to,
                          .height_m = kHeight_m,
                          .thickness_m = kWallThickness_m,
                          .finish = "white"});
  };
  add_wall("left", {left_m, kFront_m, 0}, {left_m, back_m, {}});
  add_wall("right", {right_m, kFront_m, 0}, {right_m, back_m, {}});
  add_wall("back", {left_m, back_m, 0}, {right_m, back_m, {}});
  for (size_t i = 0; i < field.cylinders.size(); ++i) {
    plan.movers.push_back(MoverOf(field.cylinders[i], i));
  }
  return plan;
}

}  // namespace treeline::building

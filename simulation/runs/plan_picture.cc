#include "simulation/runs/plan_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace treeline::runs {
namespace {

using Rgb = std::array<uint8_t, 3>;

constexpr Rgb kNothing = {255, 255, 255};
constexpr Rgb kWall = {20, 20, 20};
constexpr Rgb kGlass = {90, 160, 220};
constexpr Rgb kTour = {150, 150, 150};
constexpr Rgb kTrack = {30, 90, 220};
constexpr Rgb kStart = {20, 160, 60};
constexpr Rgb kMover = {0, 140, 140};
constexpr Rgb kGoal = {0, 170, 60};
constexpr Rgb kPath = {200, 0, 200};
constexpr Rgb kEstimate = {220, 20, 20};
constexpr Rgb kByRobot = {220, 20, 20};
constexpr Rgb kNotByRobot = {240, 150, 20};
constexpr Rgb kFall = {150, 30, 180};

constexpr double kMargin_m = 0.3;
constexpr double kMax_px = 1600;
constexpr double kFinest_m = 0.01;
// What is higher above the ground is not shown.
constexpr double kOverhead_m = 2.0;

// From the world to pixels, and onto them.
class Plan {
 public:
  explicit Plan(const simulator::Bounds& bounds)
      : low_{bounds.low.x - kMargin_m, bounds.low.y - kMargin_m} {
    const double width_m = bounds.high.x - bounds.low.x + 2 * kMargin_m;
    const double height_m = bounds.high.y - bounds.low.y + 2 * kMargin_m;
    pixel_m_ = std::max(kFinest_m, std::max(width_m, height_m) / kMax_px);
    image.width = static_cast<int>(std::ceil(width_m / pixel_m_));
    image.height = static_cast<int>(std::ceil(height_m / pixel_m_));
    image.rgb.assign(static_cast<size_t>(3 * image.width * image.height), 255);
  }

  geometry::Vec2 CenterOf(int x, int y) const {
    return {low_.x + (x + 0.5) * pixel_m_,
            low_.y + (image.height - y - 0.5) * pixel_m_};
  }
  void Set(int x, int y, Rgb color) {
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
    const size_t at = static_cast<size_t>(3 * (y * image.width + x));
    std::ranges::copy(color,
                      image.rgb.begin() + static_cast<std::ptrdiff_t>(at));
  }
  void Line(geometry::Vec2 from, geometry::Vec2 to, Rgb color, int half_px) {
    const int steps = 1 + static_cast<int>(Norm(to - from) / (0.5 * pixel_m_));
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      Dot(from + t * (to - from), color, half_px);
    }
  }
  void Dot(geometry::Vec2 at, Rgb color, int half_px) {
    const int x = static_cast<int>((at.x - low_.x) / pixel_m_);
    const int y =
        image.height - 1 - static_cast<int>((at.y - low_.y) / pixel_m_);
    for (int dy = -half_px; dy <= half_px; ++dy) {
      for (int dx = -half_px; dx <= half_px; ++dx) Set(x + dx, y + dy, color);
    }
  }
  void Cross(geometry::Vec2 at, Rgb color) {
    const double reach = 10 * pixel_m_;
    Line(at - geometry::Vec2{reach, reach}, at + geometry::Vec2{reach, reach},
         color, 1);
    Line(at - geometry::Vec2{reach, -reach}, at + geometry::Vec2{reach, -reach},
         color, 1);
  }

  // From a pose half a metre ahead.
  void Arrow(const geometry::Rigid2& pose, Rgb color) {
    constexpr double kLength_m = 0.5;
    constexpr double kHead_m = 0.18;
    const auto ahead = [&pose](double turn_rad, double length_m) {
      return geometry::Vec2{length_m * std::cos(pose.yaw_rad + turn_rad),
                            length_m * std::sin(pose.yaw_rad + turn_rad)};
    };
    const geometry::Vec2 tip = pose.translation + ahead(0, kLength_m);
    Dot(pose.translation, color, 5);
    Line(pose.translation, tip, color, 2);
    Line(tip, tip + ahead(2.6, kHead_m), color, 2);
    Line(tip, tip + ahead(-2.6, kHead_m), color, 2);
  }

  image::ColorImage image;

 private:
  geometry::Vec2 low_;
  double pixel_m_ = 1;
};

Rgb Shade(Rgb color, double height_m, const simulator::Bounds& bounds) {
  const double span_m = std::max(1.0, bounds.high.z - bounds.low.z);
  const double light =
      0.85 + 0.15 * std::clamp((height_m - bounds.low.z) / span_m, 0.0, 1.0);
  for (uint8_t& channel : color) {
    channel = static_cast<uint8_t>(light * channel);
  }
  return color;
}

bool IsGround(worlds::SurfaceKind kind) {
  return kind == worlds::SurfaceKind::kFloor ||
         kind == worlds::SurfaceKind::kRamp ||
         kind == worlds::SurfaceKind::kStair;
}

Rgb ColorAt(const simulator::Terrain& terrain, geometry::Vec2 at) {
  const simulator::Bounds& bounds = terrain.bounds();
  double highest_other_m = -std::numeric_limits<double>::infinity();
  double from_m = bounds.high.z + 1;
  while (const auto ground = terrain.GroundAt(at, bounds.low.z - 1, from_m)) {
    if (!IsGround(ground->kind)) {
      // The lowest underside of what hangs or stands here.
      highest_other_m = ground->height_m;
      from_m = ground->height_m - 1e-3;
      continue;
    }
    if (highest_other_m < ground->height_m + kOverhead_m &&
        highest_other_m > ground->height_m) {
      return {110, 105, 100};
    }
    switch (ground->kind) {
      case worlds::SurfaceKind::kRamp:
        return Shade({235, 205, 130}, ground->height_m, bounds);
      case worlds::SurfaceKind::kStair:
        return Shade({190, 140, 100}, ground->height_m, bounds);
      default:
        return Shade({225, 225, 225}, ground->height_m, bounds);
    }
  }
  return kNothing;
}

void DrawWalls(const simulator::Terrain& terrain, Plan& plan) {
  for (const simulator::TerrainQuad& quad : terrain.quads()) {
    const bool is_glass = quad.kind == worlds::SurfaceKind::kGlass;
    if (quad.kind != worlds::SurfaceKind::kWall && !is_glass) continue;
    for (size_t i = 0; i < 4; ++i) {
      const geometry::Vec3& a = quad.corners[i];
      const geometry::Vec3& b = quad.corners[(i + 1) % 4];
      plan.Line({a.x, a.y}, {b.x, b.y}, is_glass ? kGlass : kWall, 1);
    }
  }
}

void DrawEvents(const SimulationResult& result, Plan& plan) {
  for (const simulator::SimEvent& event : result.events) {
    const geometry::Vec2 at = {event.point_in_world.x, event.point_in_world.y};
    switch (event.kind) {
      case simulator::SimEventKind::kCollision:
        plan.Cross(at, event.caused_by_robot ? kByRobot : kNotByRobot);
        break;
      case simulator::SimEventKind::kFall:
      case simulator::SimEventKind::kStairs:
      case simulator::SimEventKind::kTipped:
        plan.Cross(at, kFall);
        break;
      default:
        break;
    }
  }
}

void DrawMarks(const PlanMarks& marks, Plan& plan) {
  for (const std::vector<geometry::Vec2>& way : marks.movers) {
    for (size_t i = 1; i < way.size(); ++i) {
      plan.Line(way[i - 1], way[i], kMover, 1);
    }
    if (!way.empty()) plan.Dot(way.back(), kMover, 8);
  }
  for (size_t i = 1; i < marks.path.size(); ++i) {
    const geometry::Vec3& a = marks.path[i - 1];
    const geometry::Vec3& b = marks.path[i];
    plan.Line({a.x, a.y}, {b.x, b.y}, kPath, 0);
  }
  if (marks.goal.has_value()) plan.Arrow(*marks.goal, kGoal);
  if (marks.truth.has_value()) plan.Arrow(*marks.truth, kTrack);
  if (marks.estimate.has_value()) plan.Arrow(*marks.estimate, kEstimate);
}

// Of the world, or of the part of it that is to be shown.
simulator::Bounds ShownBounds(const simulator::Bounds& world,
                              const SimulationResult& result,
                              const PlanMarks& marks) {
  if (!marks.within_m.has_value()) return world;
  std::vector<geometry::Vec2> points;
  for (const std::vector<geometry::Vec3>& line : result.track) {
    for (const geometry::Vec3& at : line) points.push_back({at.x, at.y});
  }
  if (marks.goal.has_value()) points.push_back(marks.goal->translation);
  if (points.empty()) return world;
  simulator::Bounds shown = world;
  const auto [west, east] = std::ranges::minmax(
      points, {}, [](geometry::Vec2 point) { return point.x; });
  const auto [south, north] = std::ranges::minmax(
      points, {}, [](geometry::Vec2 point) { return point.y; });
  shown.low.x = std::max(shown.low.x, west.x - *marks.within_m);
  shown.low.y = std::max(shown.low.y, south.y - *marks.within_m);
  shown.high.x = std::min(shown.high.x, east.x + *marks.within_m);
  shown.high.y = std::min(shown.high.y, north.y + *marks.within_m);
  return shown;
}

}  // namespace

std::vector<std::vector<geometry::Vec2>> WaysOfMovers(
    const worlds::World& world, double time_s, double last_s) {
  constexpr double kStep_s = 0.1;
  // Further than anything goes in a step: it has begun anew.
  constexpr double kJump_m = 1;
  std::vector<std::vector<geometry::Vec2>> ways;
  for (double before_s = last_s; before_s > -kStep_s / 2; before_s -= kStep_s) {
    const std::vector<worlds::BodyInstance> bodies =
        world.InstancesAt(std::max(0.0, time_s - before_s));
    ways.resize(bodies.size());
    for (size_t i = 0; i < bodies.size(); ++i) {
      const worlds::Float3 at = bodies[i].world_from_body.origin;
      const geometry::Vec2 point{at.x, at.y};
      if (!ways[i].empty() &&
          geometry::Norm(point - ways[i].back()) > kJump_m) {
        ways[i].clear();
      }
      ways[i].push_back(point);
    }
  }
  return ways;
}

image::ColorImage DrawPlan(const worlds::World& world,
                           const simulator::Terrain& terrain,
                           const SimulationResult& result,
                           const PlanMarks& marks) {
  Plan plan(ShownBounds(terrain.bounds(), result, marks));
  for (int y = 0; y < plan.image.height; ++y) {
    for (int x = 0; x < plan.image.width; ++x) {
      plan.Set(x, y, ColorAt(terrain, plan.CenterOf(x, y)));
    }
  }
  DrawWalls(terrain, plan);
  for (size_t i = 0; i < world.tour.size(); ++i) {
    const worlds::Float3& a = world.tour[i];
    const worlds::Float3& b = world.tour[(i + 1) % world.tour.size()];
    plan.Line({a.x, a.y}, {b.x, b.y}, kTour, 0);
  }
  for (const std::vector<geometry::Vec3>& line : result.track) {
    for (size_t i = 1; i < line.size(); ++i) {
      plan.Line({line[i - 1].x, line[i - 1].y}, {line[i].x, line[i].y}, kTrack,
                1);
    }
  }
  if (!result.track.empty() && !result.track.front().empty()) {
    const geometry::Vec3& start = result.track.front().front();
    plan.Dot({start.x, start.y}, kStart, 6);
  }
  DrawMarks(marks, plan);
  DrawEvents(result, plan);
  return std::move(plan.image);
}

}  // namespace treeline::runs

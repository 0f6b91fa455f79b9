// A room with a dock in it, as a laser sees it, for tests.
#ifndef NAV_AGENT_DOCKING_TESTING_DOCK_ROOM_H_
#define NAV_AGENT_DOCKING_TESTING_DOCK_ROOM_H_

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/base/random.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/docking/dock.h"

namespace treeline::docking {

// 4 x 3 m with a pillar; seen by the default robot's laser, 270 degrees with a
// beam every half degree and 1 cm of noise. The dock is at (3, 1.5), its body
// 2 cm before a docked robot.
class DockRoom {
 public:
  DockRoom() {
    AddBox({2, 1.5}, 2, 1.5);
    AddBox({1, 0.3}, 0.15, 0.15);
    PutDock({});
  }
  static Dock Charger() {
    return {
        .name = "charger", .map_from_docked = {{3, 1.5}, 0}, .staging_m = 0.85};
  }
  // The dock's body, `by` from where it was made.
  void PutDock(geometry::Vec2 by) {
    body_.clear();
    AddBoxTo(body_, geometry::Vec2{3.42, 1.5} + by, 0.1, 0.1);
  }
  void AddBox(geometry::Vec2 center, double half_x_m, double half_y_m) {
    AddBoxTo(walls_, center, half_x_m, half_y_m);
  }
  static core::RangeSensorInfo Laser() {
    return {.angle_min_rad = -0.75 * std::numbers::pi,
            .angle_increment_rad = std::numbers::pi / 360,
            .beams = 541,
            .range_min_m = 0.02,
            .range_max_m = 30,
            .beam_interval_s = 0,
            .scan_interval_s = 0.025};
  }
  // What a robot that stands there measures, beam by beam (m).
  std::vector<float> Ranges_m(const geometry::Rigid2& map_from_base) {
    std::vector<float> ranges_m;
    const geometry::Vec2 from = map_from_base * LaserInBase();
    for (int i = 0; i < Laser().beams; ++i) {
      const geometry::Vec2 to =
          map_from_base * (LaserInBase() + BeamAt(i)) - from;
      ranges_m.push_back(static_cast<float>(RangeOf_m(from, to) +
                                            0.01 * random_.NextGaussian()));
    }
    return ranges_m;
  }
  // The same as where beams end in its base (m).
  std::vector<geometry::Vec2> Scan(const geometry::Rigid2& map_from_base) {
    std::vector<geometry::Vec2> ends;
    for (const float range_m : Ranges_m(map_from_base)) {
      ends.push_back(LaserInBase() + static_cast<double>(range_m) *
                                         BeamAt(static_cast<int>(ends.size())));
    }
    return ends;
  }
  static std::vector<geometry::Vec2> Placed(
      const geometry::Rigid2& map_from_base,
      std::vector<geometry::Vec2> points) {
    for (geometry::Vec2& point : points) point = map_from_base * point;
    return points;
  }

  const core::RobotModel robot;

 private:
  struct Wall {
    geometry::Vec2 from;
    geometry::Vec2 to;
  };
  static void AddBoxTo(std::vector<Wall>& walls, geometry::Vec2 center,
                       double half_x_m, double half_y_m) {
    const geometry::Vec2 x = {half_x_m, 0};
    const geometry::Vec2 y = {0, half_y_m};
    const geometry::Vec2 corners[] = {center - x - y, center + x - y,
                                      center + x + y, center - x + y};
    for (size_t i = 0; i < 4; ++i) {
      walls.push_back({corners[i], corners[(i + 1) % 4]});
    }
  }
  geometry::Vec2 LaserInBase() const {
    return {robot.base_from_laser.translation.x, 0};
  }
  static geometry::Vec2 BeamAt(int i) {
    const double angle_rad = Laser().AngleOf_rad(i);
    return {std::cos(angle_rad), std::sin(angle_rad)};
  }
  double RangeOf_m(geometry::Vec2 from, geometry::Vec2 beam) const {
    double nearest_m = 1e9;
    for (const auto* walls : {&walls_, &body_}) {
      for (const Wall& wall : *walls) {
        const geometry::Vec2 along = wall.to - wall.from;
        const double across = geometry::Cross(beam, along);
        if (std::abs(across) < 1e-12) continue;
        const double range_m =
            geometry::Cross(wall.from - from, along) / across;
        const double share = geometry::Cross(wall.from - from, beam) / across;
        if (range_m > 0 && share >= 0 && share <= 1) {
          nearest_m = std::min(nearest_m, range_m);
        }
      }
    }
    return nearest_m;
  }

  std::vector<Wall> walls_;
  std::vector<Wall> body_;
  base::Random random_{1, 1};
};

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_TESTING_DOCK_ROOM_H_

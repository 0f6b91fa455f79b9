// How a robot stands on the ground: height, pitch and roll from what its
// wheels and casters touch.
#ifndef SIMULATION_SIMULATOR_FOOTING_H_
#define SIMULATION_SIMULATOR_FOOTING_H_

#include <array>
#include <optional>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/robot_model.h"
#include "simulation/simulator/terrain.h"

namespace treeline::simulator {

// What touches the ground, in the order of Stance's arrays.
enum Foot { kLeftWheel, kRightWheel, kFrontCaster, kRearCaster, kFeet };

// The height of the base is that of the middle between its wheels' contacts,
// roll is the slope between them, and pitch that between its casters', which
// are sprung:
//   z = (left + right) / 2,  tan(pitch) = (rear - front) / (2 caster'),
//   tan(roll) = s / sqrt(cos^2(pitch) - s^2 sin^2(pitch)),
//   s = (left - right) / track'
// with the distances caster' and track' as seen from above.
struct Stance {
  geometry::Vec2 position;
  double yaw_rad = 0;
  // Nose down and right side down are positive (REP 103).
  double pitch_rad = 0;
  double roll_rad = 0;
  double height_m = 0;
  // Where the feet touch the ground.
  std::array<geometry::Vec3, kFeet> contacts{};

  // World from base: Rz(yaw) Ry(pitch) Rx(roll).
  geometry::Rigid3 WorldFromBase() const;
  // The angle between the base's z axis and the vertical.
  double Tilt_rad() const;
};

// Immutable; the terrain must outlive it.
class Footing {
 public:
  Footing(const Terrain& terrain, const core::RobotModel& robot);

  struct Step {
    // nullopt: a foot lost the ground.
    std::optional<Stance> stance;
    // Where it did, and whether that is above stairs.
    geometry::Vec3 lost_at{};
    bool above_stairs = false;
  };
  // The robot moves a little, to here: each foot finds ground at most
  // max_step_m higher or lower than where it stood.
  Step Follow(const Stance& before, geometry::Vec2 position,
              double yaw_rad) const;

  // The robot is put down with its base on the ground nearest to height_m.
  // nullopt if there is none, or a foot hangs in the air.
  std::optional<Stance> PutDown(geometry::Vec2 position, double yaw_rad,
                                double height_m) const;

  // The ground nearest to a height.
  std::optional<double> NearestGround_m(geometry::Vec2 at,
                                        double height_m) const;

 private:
  geometry::Vec2 FootAt(int foot, const Stance& tilted, geometry::Vec2 position,
                        double yaw_rad) const;
  bool IsAboveStairs(geometry::Vec3 at) const;
  void Settle(Stance& stance) const;

  const Terrain* terrain_;
  std::array<geometry::Vec2, kFeet> feet_in_base_;
  double max_step_m_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_FOOTING_H_

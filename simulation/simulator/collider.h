// What a robot runs into: its body and its feet against everything solid.
#ifndef SIMULATION_SIMULATOR_COLLIDER_H_
#define SIMULATION_SIMULATOR_COLLIDER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav_agent/core/robot_model.h"
#include "simulation/simulator/footing.h"
#include "simulation/simulator/oriented_box.h"
#include "simulation/simulator/stage.h"
#include "simulation/simulator/terrain.h"

namespace treeline::simulator {

struct Contact {
  geometry::Vec3 point_in_world;
  // "wall", "step", "person 1", ...
  std::string what;
  // Which of the actors; -1: what never moves.
  int actor = -1;
};

// The volumes of a robot that nothing solid may reach into: its body, an
// oriented box over the footprint from the ground clearance to its height,
// tilted as it stands; and at each foot a small upright box from max_step_m to
// the ground clearance, which finds steps that are too high to climb.
//
// Each check is exact for one stance. Every way into these boxes leads
// through at least 4 cm of their inside, and between two checks (5 ms) neither
// a robot nor a person moves as much as 2 cm, so nothing passes unseen however
// thin it is. Not thread-safe (it remembers what is near).
class Collider {
 public:
  // Both must outlive it.
  Collider(const Terrain& terrain, const Stage& stage,
           const core::RobotModel& robot);

  // The first thing that never moves and reaches into the robot.
  std::optional<Contact> FindFixed(const Stance& stance);
  // The first of the actors that does, from actor `first` on.
  std::optional<Contact> FindMoving(const Stance& stance,
                                    std::span<const Actor> actors,
                                    size_t first = 0) const;

 private:
  std::vector<OrientedBox> BoxesAt(const Stance& stance) const;

  const Terrain* terrain_;
  const Stage* stage_;
  core::RobotModel robot_;
  // What is near near_center_, with some room to move.
  std::vector<uint32_t> near_;
  std::optional<geometry::Vec2> near_center_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_COLLIDER_H_

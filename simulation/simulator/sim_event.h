// What happened in a simulation that somebody should know of.
#ifndef SIMULATION_SIMULATOR_SIM_EVENT_H_
#define SIMULATION_SIMULATOR_SIM_EVENT_H_

#include <string>

#include "common/geometry/rigid3.h"
#include "simulation/simulator/fault.h"

namespace treeline::simulator {

enum class SimEventKind {
  kCollision,   // something solid reached into the robot, or it into that
  kFall,        // a foot lost the ground: the robot is `fallen`
  kStairs,      // the same above stairs
  kTipped,      // the ground was too steep to stand on: `fallen` too
  kSteep,       // steeper than the robot's limit, but it stands
  kPlaced,      // kidnapped: it stands elsewhere from now on
  kFaultBegan,  // what: Fault::Name()
  kFaultEnded,
  kObstacle,       // one was put there, moved or removed; a door turned
  kOdometryReset,  // wheel counters begin at 0 again
  kScenario        // an action of a scenario could not be done; what: why
};

// "collision" and so on.
const char* SimEventName(SimEventKind kind);

struct SimEvent {
  SimEventKind kind = SimEventKind::kCollision;
  SimTime time{0};
  // Where it happened: the point of contact, the foot that fell.
  geometry::Vec3 point_in_world;
  geometry::Rigid3 world_from_base;
  // What was hit, by name.
  std::string what;
  // Of a collision: whether the robot's own motion led to it: what stands
  // still, it ran into; towards what moves, its edge moved at more than 1 cm/s
  // at the point of contact. How fast each moved towards the other there, at
  // right angles to that edge.
  bool caused_by_robot = false;
  double robot_approach_mps = 0;
  double body_approach_mps = 0;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SIM_EVENT_H_

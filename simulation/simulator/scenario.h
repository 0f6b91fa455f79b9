// What happens in a simulation, written down: the world, the robot, and what
// is done to it when. docs/reference/simulator.md describes the files.
#ifndef SIMULATION_SIMULATOR_SCENARIO_H_
#define SIMULATION_SIMULATOR_SCENARIO_H_

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "simulation/simulator/simulator.h"
#include "simulation/simulator/tour_driver.h"

namespace treeline::simulator {

// Drives at these speeds for a while.
struct DriveAction {
  core::VelocityCommand command;
  SimTime duration{0};
};
// Drives along the world's tour, or these corners, by the true pose, until
// another drive begins.
struct TourAction {
  TourOptions options;
  std::vector<geometry::Vec3> corners;  // none: the world's tour
};
struct StopAction {};
struct KidnapAction {
  // Of the two, one.
  std::string place;
  std::optional<RobotPlacement> placement;
};
struct FaultAction {
  Fault fault;
};
struct ResetOdometryAction {};
struct AddObstacleAction {
  std::string name;
  std::string body;
  RobotPlacement placement;
  // Factors on the body's measures.
  worlds::Float3 scale{1, 1, 1};
};
struct RemoveObstacleAction {
  std::string name;
};
struct MoveBodyAction {
  std::string name;
  RobotPlacement placement;
};
struct DoorAction {
  std::string name;
  double angle_rad = 0;
};
struct ReleaseAction {
  std::string name;
};

struct ScenarioAction {
  SimTime at{0};
  // In the file, for messages; 0: none.
  int line = 0;
  std::variant<DriveAction, TourAction, StopAction, KidnapAction, FaultAction,
               ResetOdometryAction, AddObstacleAction, RemoveObstacleAction,
               MoveBodyAction, DoorAction, ReleaseAction>
      what{};
};

struct Scenario {
  std::string world = "cafe";
  worlds::WorldOptions world_options;
  // Where the robot starts: a place of the world, or here. Neither: at the
  // tour's first corner where nobody stands, along the tour.
  std::string start_place;
  std::optional<RobotPlacement> start;
  SimulatorOptions options;
  // 0: as long as somebody wants.
  SimTime duration{0};
  // In order of time.
  std::vector<ScenarioAction> actions;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SCENARIO_H_

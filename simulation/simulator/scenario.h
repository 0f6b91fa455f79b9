// What happens in a simulation, written down: the world, the robot, and what
// is done to it when. docs/reference/simulator.md describes the files.
#ifndef SIMULATION_SIMULATOR_SCENARIO_H_
#define SIMULATION_SIMULATOR_SCENARIO_H_

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
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

// The scenario in a YAML text. INVALID_ARGUMENT begins with "NAME:LINE: ".
absl::StatusOr<Scenario> ParseScenario(absl::string_view text,
                                       absl::string_view name);
absl::StatusOr<Scenario> ReadScenario(const std::string& path);

// Where the scenario starts in `world`. NOT_FOUND: no such place (and which
// there are); FAILED_PRECONDITION: no start is given and the world has no tour.
absl::StatusOr<RobotPlacement> StartOf(const Scenario& scenario,
                                       const worlds::World& world);

// Plays a scenario: steps a simulator and does everything at its time, so that
// the result does not depend on how time is divided into Steps. Commands of
// drives are renewed every 50 ms. What cannot be done (a kidnap into a wall) is
// recorded as an event. Not thread-safe.
class ScenarioPlayer {
 public:
  // The simulator must outlive it, and be at time 0.
  ScenarioPlayer(const Scenario& scenario, Simulator& simulator);

  void Step(SimTime duration);

  // Drives on as a tour from now.
  void DriveTour(const TourAction& tour);
  // Whether the tour that is driven has come to its end.
  bool is_tour_done() const { return tour_ != nullptr && tour_->is_done(); }
  const TourDriver* tour() const { return tour_.get(); }

 private:
  void Do(const ScenarioAction& action);
  absl::Status DoKidnap(const KidnapAction& kidnap);
  // Whether somebody stands before a robot on its tour.
  bool IsWayTaken() const;
  void Steer();

  Simulator* simulator_;
  std::vector<ScenarioAction> actions_;
  size_t next_action_ = 0;
  SimTime next_steering_{0};
  std::unique_ptr<TourDriver> tour_;
  std::optional<core::VelocityCommand> command_;
  SimTime command_end_{0};
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SCENARIO_H_

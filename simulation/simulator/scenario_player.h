// Plays scenarios.
#ifndef SIMULATION_SIMULATOR_SCENARIO_PLAYER_H_
#define SIMULATION_SIMULATOR_SCENARIO_PLAYER_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/simulator.h"
#include "simulation/simulator/tour_driver.h"

namespace treeline::simulator {

// Where the scenario starts in `world`. NOT_FOUND: no such place (and which
// there are); FAILED_PRECONDITION: no start is given and the world has no tour.
absl::StatusOr<RobotPlacement> StartOf(const Scenario& scenario,
                                       const worlds::World& world);

// The scenario's world; sets options.start to where the scenario starts in it.
// Errors of worlds::MakeWorld and StartOf.
absl::StatusOr<worlds::World> MakeWorldOf(Scenario& scenario);

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

#endif  // SIMULATION_SIMULATOR_SCENARIO_PLAYER_H_

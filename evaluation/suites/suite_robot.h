// A simulated robot with a navigator, and a record of what it does.
#ifndef EVALUATION_SUITES_SUITE_ROBOT_H_
#define EVALUATION_SUITES_SUITE_ROBOT_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "evaluation/suites/suite_place.h"
#include "nav_agent/core/robot_file.h"
#include "simulation/runs/simulation_run.h"

namespace treeline::suites {

// Simulated time between two steps of the navigator.
inline constexpr simulator::SimTime kSuiteStep = std::chrono::milliseconds(25);
// A plan is handed over so many steps after it was begun, 0.2 s.
inline constexpr int kSuitePlanSteps = 8;

// The circle that holds a robot's footprint, in whole cells of places.
double PlaceRadius_m(const core::RobotModel& robot);

struct SuiteRobotOptions {
  simulator::RobotPlacement start;
  uint64_t seed = 0;
  // Measures, speeds, lasers and noise; nullopt: the default robot's.
  std::optional<core::RobotDescription> robot = std::nullopt;
  // RGB-D frames in a second; 0: there is no camera.
  double camera_hz = 0;
  // Whether a laser looks back, of a robot that has one.
  bool has_rear_laser = true;
  // Of its pictures: see SensorOptions.
  double camera_scale = 1;
  bool camera_is_lit = true;
  // Makes the port of a server that runs by the simulation's clock; null:
  // there is none.
  std::function<std::unique_ptr<core::RelocalizationPort>(const base::Clock&)>
      make_server = nullptr;
  behavior::NavigatorOptions navigator;
};

// What Navigator::Step took, of processor time (ms): without the simulator's
// part, which is the rendering of the pictures that it takes.
struct StepTimes {
  int64_t steps = 0;
  // Steps that took longer than the time from one to the next.
  int64_t missed = 0;
  double total_ms = 0;
  double highest_ms = 0;
  // Plans, made in a thread of their own: none of the steps' time. `late` would
  // not have been there by the step that they were handed over in.
  behavior::PlanTally plans;
  // How many took up to 0.25 ms, 0.5 ms, 1 ms, 2 ms ...: of percentiles.
  std::vector<int64_t> histogram = std::vector<int64_t>(16, 0);

  void Add(double step_ms);
  void Add(const StepTimes& other);
  // The upper edge of the bin below which that share of all steps is.
  double Percentile_ms(double share) const;
};

class SuiteRobot {
 public:
  // `world` is the place's, or the same with more in it. The place must outlive
  // the robot. Errors of Simulator and Navigator.
  static absl::StatusOr<std::unique_ptr<SuiteRobot>> Create(
      const SuitePlace& place, worlds::World world,
      const SuiteRobotOptions& options);
  ~SuiteRobot();

  simulator::Simulator& simulator() { return *simulator_; }
  behavior::Navigator& navigator() { return *navigator_; }
  const behavior::Navigator& navigator() const { return *navigator_; }
  const SuitePlace& place() const { return *place_; }

  // 25 ms: the world goes on, then the navigator thinks.
  void Step();
  double now_s() const { return simulator::Seconds(simulator_->now()); }

  // Tells it where it is, right or wrong.
  absl::Status Tell(const core::LevelPose& pose);
  // The newest estimate's error; nullopt: there is none.
  std::optional<PoseMiss> EstimateError() const;

  // ---- the record ----
  // Track and events, for the plan.
  const runs::SimulationResult& record() const { return record_; }
  const std::vector<behavior::NavigatorEvent>& navigator_events() const {
    return navigator_events_;
  }
  StepTimes step_times() const;

 private:
  class Camera;
  explicit SuiteRobot(const SuitePlace& place);
  void Record();

  const SuitePlace* place_;
  std::unique_ptr<simulator::Simulator> simulator_;
  std::unique_ptr<Camera> camera_;
  std::unique_ptr<core::RelocalizationPort> server_;
  std::unique_ptr<behavior::Navigator> navigator_;
  runs::SimulationResult record_;
  std::vector<behavior::NavigatorEvent> navigator_events_;
  StepTimes times_;
};

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_ROBOT_H_

// A robot in a synthetic world, in simulated time, behind the same ports as
// the real one. docs/reference/simulator.md describes the model.
#ifndef SIMULATION_SIMULATOR_SIMULATOR_H_
#define SIMULATION_SIMULATOR_SIMULATOR_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/core/devices.h"
#include "simulation/simulator/robot_body.h"
#include "simulation/simulator/sensor_suite.h"
#include "simulation/worlds/world.h"

namespace treeline::simulator {

// Where a robot is put: on the ground nearest to height_m.
struct RobotPlacement {
  geometry::Vec2 position;
  double yaw_rad = 0;
  double height_m = 0;
};

struct SimulatorOptions {
  core::RobotModel robot;
  WheelOdometryErrors errors;
  SensorOptions sensors;
  RobotPlacement start;
  // Of everything random: wheels, slip, noise, lost beams.
  uint64_t seed = 0;
  // For pictures; < 1: all. Results do not depend on it.
  int threads = 1;
};

// The truth, which no robot knows.
struct TrueState {
  SimTime time{0};
  geometry::Rigid3 world_from_base;
  double forward_mps = 0;
  double yaw_rate_radps = 0;
  bool is_fallen = false;
  bool is_blocked = false;
  // Since the beginning; teleports do not count.
  double distance_m = 0;
  double turned_rad = 0;
};

// The same world, options, calls and simulated times of the calls give the same
// motion and the same sensor data, byte for byte, however time is divided into
// Steps and on any number of threads. Thread-safe; Step by one thread at a
// time.
class Simulator {
 public:
  // INVALID_ARGUMENT for options out of range; NOT_FOUND and
  // FAILED_PRECONDITION if the robot cannot stand at its start.
  static absl::StatusOr<std::unique_ptr<Simulator>> Create(
      worlds::World world, const SimulatorOptions& options);

  // Lets simulated time pass.
  void Step(SimTime duration);

  // ---- what an agent has ----
  const base::Clock& clock() const { return clock_; }
  core::RangeSensor& laser() { return sensors_->laser(); }
  // Null: nothing looks back.
  core::RangeSensor* rear_laser() { return sensors_->rear_laser(); }
  core::Odometry& odometry() { return sensors_->odometry(); }
  // Without a camera (camera_hz 0) there are never any frames.
  SimulatedCamera& camera() { return sensors_->camera(); }
  core::BaseDriver& base() { return base_; }

  // ---- what the world does to it ----
  SimTime now() const { return clock_.now(); }
  const worlds::World& world() const { return *world_; }
  const Terrain& terrain() const { return terrain_; }
  const renderer::RayCaster& caster() const { return caster_; }
  const SimulatorOptions& options() const { return options_; }
  TrueState state() const;
  // The true pose a short while ago (half a second at most), at the time of a
  // measurement for instance.
  geometry::Rigid3 WorldFromBaseAt(SimTime time) const;
  std::vector<worlds::BodyInstance> bodies() const;
  // Everything that happened since the last call.
  std::vector<SimEvent> TakeEvents();

  // Kidnaps the robot, or puts a fallen one back on its wheels: it stands
  // there now, and its wheels have not felt anything. NOT_FOUND: no such place
  // (and which there are), no ground; FAILED_PRECONDITION: no room (what is in
  // the way), too steep.
  absl::Status Kidnap(const RobotPlacement& placement);
  absl::Status KidnapTo(absl::string_view place);

  // INVALID_ARGUMENT as Fault::Validate; fault.start counts from now on.
  absl::Status Inject(Fault fault);
  // Ends the faults of a target.
  void Repair(FaultTarget target);
  // Whether relocalization servers are meant to be dead (FaultTarget::kServer).
  bool IsServerDead() const;
  void ResetOdometry();

  // See Stage. Obstacles stand on the ground nearest to height_m.
  absl::Status AddObstacle(absl::string_view name, absl::string_view body,
                           const RobotPlacement& placement,
                           worlds::Float3 scale = {1, 1, 1});
  absl::Status RemoveObstacle(absl::string_view name);
  absl::Status MoveBody(absl::string_view name,
                        const RobotPlacement& placement);
  absl::Status TurnDoor(absl::string_view name, double angle_rad);
  absl::Status ReleaseBody(absl::string_view name);
  // Records that an action could not be done.
  void ReportScenario(const std::string& why);

 private:
  Simulator(std::unique_ptr<const worlds::World> world,
            renderer::RayCaster caster, const SimulatorOptions& options);
  void StepOnce() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RecordFaults(SimTime from, SimTime until)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Record(SimEventKind kind, absl::string_view what)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status ChangeStage(
      const std::string& what,
      const std::function<absl::Status(Stage& stage)>& change);
  absl::StatusOr<worlds::Placement> OnGround(
      const RobotPlacement& placement) const;

  const std::unique_ptr<const worlds::World> world_;
  const SimulatorOptions options_;
  const renderer::RayCaster caster_;
  const Terrain terrain_;
  SimClock clock_;
  SimulatedBase base_;
  mutable absl::Mutex mutex_;
  Stage stage_ ABSL_GUARDED_BY(mutex_);
  RobotBody body_ ABSL_GUARDED_BY(mutex_);
  FaultPlan faults_ ABSL_GUARDED_BY(mutex_);
  // The suite's Step and Restart under mutex_; its devices are thread-safe.
  std::unique_ptr<SensorSuite> sensors_;
  std::vector<SimEvent> events_ ABSL_GUARDED_BY(mutex_);
  // Steps taken.
  int64_t steps_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SIMULATOR_H_

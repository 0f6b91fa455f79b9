// The robot that an agent drives: real, or simulated.
#ifndef NAV_AGENT_APP_RUN_AGENT_ROBOT_H_
#define NAV_AGENT_APP_RUN_AGENT_ROBOT_H_

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/app/hardware/robot_hardware.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/docking/dock.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/simulation_control.h"
#include "simulation/simulator/simulated_battery.h"
#include "simulation/worlds/world.h"

namespace treeline::run_app {

// A dock, and the ground that it stands on.
struct PlacedDock {
  docking::Dock dock;
  double height_m = 0;
};

// Everything by one thread, but for what the devices say of themselves.
class AgentRobot {
 public:
  virtual ~AgentRobot() = default;

  // Without a server. Valid for as long as this is.
  virtual behavior::NavigatorDevices Devices() = 0;
  // What the devices' stamps are of.
  virtual const base::Clock& clock() const = 0;
  virtual const core::RobotModel& model() const = 0;
  // What its measurements are to be corrected by; a simulated robot's by
  // nothing.
  virtual core::SensorCorrection correction() const { return {}; }
  // nullopt: nobody measured it.
  virtual std::optional<core::MeasuredOdometryNoise> noise() const {
    return std::nullopt;
  }
  virtual core::ContactEnd contacts() const {
    return core::ContactEnd::kUnsaid;
  }
  // Lets simulated time pass; a real robot's passes by itself.
  virtual void Advance(std::chrono::nanoseconds duration) = 0;
  // What it tells apart from its wheels; nullopt: nothing.
  virtual std::optional<core::Battery> Battery() const { return std::nullopt; }

  // ---- of a simulated robot ----
  // A charger stands at each dock.
  virtual void SetChargers(const std::vector<PlacedDock>& /*docks*/) {}
  virtual agent_service::SimulationControl* simulation() { return nullptr; }
  virtual std::string world() const { return ""; }
  virtual std::vector<std::string> places() const { return {}; }
  virtual std::optional<geometry::Rigid3> TrueMapFromBase() const {
    return std::nullopt;
  }
  virtual std::vector<agent_service::ObstacleReport> Obstacles() const {
    return {};
  }
  // What happened to it since the last call, for the log: "collision: chair".
  virtual std::vector<std::string> TakeIncidents() { return {}; }
};

absl::StatusOr<std::unique_ptr<AgentRobot>> MakeRealRobot(
    const hardware::HardwareConfig& config);

struct SimulatedRobotOptions {
  // World's name or file.
  std::string world;
  // Painted if there is a camera, whatever they say.
  worlds::WorldOptions world_options;
  uint64_t seed = 0;
  // Frames in a second; 0: no camera, [0, 60].
  double camera_hz = 5;
  core::RobotDescription robot;
  // Whether the robot's laser that looks back, if it has one, is there.
  bool has_rear_laser = true;
  // The map was made by a drive that began where this robot starts: its frame
  // is the base's there. Else it is the world's.
  bool map_begins_at_start = false;
  // Where it will be put before it begins, in the map; people keep off there,
  // too.
  std::optional<geometry::Vec2> start_at = std::nullopt;
  simulator::SimulatedBatteryOptions battery = {};
};
// Errors as MakeWorld and Simulator::Create.
absl::StatusOr<std::unique_ptr<AgentRobot>> MakeSimulatedRobot(
    const SimulatedRobotOptions& options);

// The perfect map of a world, for robots that have driven through none.
absl::StatusOr<behavior::NavigatorMap> MapOfWorld(const std::string& world);

// What is shown where there is no map: one level of free ground about the
// origin.
behavior::NavigatorMap BlankMap();

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_AGENT_ROBOT_H_

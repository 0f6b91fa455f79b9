// The robot's mind: goals in, velocities out (thesis 6.5-6.6).
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/behavior/navigator_options.h"
#include "nav_agent/behavior/navigator_snapshot.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline::behavior {

// The devices must outlive the navigator. rear_laser (that looks back), camera,
// server: null if none.
struct NavigatorDevices {
  core::RangeSensor& laser;
  core::Odometry& odometry;
  core::BaseDriver& base;
  core::RangeSensor* rear_laser = nullptr;
  core::RgbdCamera* camera = nullptr;
  core::RelocalizationPort* server = nullptr;
};

struct NavigationGoal {
  // Driven through in order, without a stop and whatever the heading there; the
  // last is the goal. Of a place only the level counts: its height is the
  // map's.
  std::vector<core::LevelPose> poses;
};

// What a program above the navigator has the robot do at its dock.
struct SteeringCommand {
  core::VelocityCommand wanted;
  // Where the robot stands at last, and whether its rear is at the dock then.
  core::LevelPose docked;
  bool is_backward = false;
  // Out of it: no keep-out zone holds the robot in.
  bool is_leaving = false;
  // What it does, for people.
  std::string what;
};

struct NavigatorMap {
  octree::VoxelMap voxels;
  traversability::TraversableMap levels;
};

// Single-threaded: everything is called by the thread that steps. Time is the
// injected clock's. Deterministic if the devices and the plan budget are.
class Navigator {
 public:
  static absl::StatusOr<std::unique_ptr<Navigator>> Create(
      const NavigatorMap& map, const core::RobotModel& robot,
      const NavigatorDevices& devices, const NavigatorOptions& options,
      const base::Clock& clock);
  virtual ~Navigator() = default;

  // control_hz times a second: reads the devices, thinks, commands the base.
  virtual void Step() = 0;

  // Replaces the goal there is. INVALID_ARGUMENT: none, or not finite.
  // FAILED_PRECONDITION: the robot is stopped, or a pose lies in a zone that it
  // is kept out of.
  virtual absl::StatusOr<uint64_t> SetGoal(const NavigationGoal& goal) = 0;
  // NOT_FOUND: that goal is not the current one. 0: whichever there is.
  virtual absl::Status CancelGoal(uint64_t id) = 0;
  virtual void Pause() = 0;
  virtual void Resume() = 0;
  // The robot stands from the next step on, whatever happens, until Release;
  // its goal ends, and no other is taken. why: for people.
  virtual void Stop(const std::string& why) = 0;
  // Nothing begins to move by that: a search for the robot's place waits for
  // Resume.
  virtual void Release() = 0;
  // Drives so for kManualLease_s, as far as limits and obstacles allow: who
  // drives by hand says it again and again, and nothing moves when they fall
  // silent. A goal or a search waits for Resume afterwards. INVALID_ARGUMENT:
  // not finite. FAILED_PRECONDITION: it is stopped, or a device is lost.
  virtual absl::Status Drive(const core::VelocityCommand& wanted) = 0;
  // Drives so in the next step, and in no other: who steers says it again in
  // each. As far as limits and obstacles allow, but for the dock, which may be
  // driven up to; and not while the robot is paused, driven by hand, looks for
  // its place, or a device is lost. A goal waits meanwhile, and is planned
  // anew. INVALID_ARGUMENT: not finite. FAILED_PRECONDITION: it is stopped, the
  // dock lies in a zone that it is kept out of, or it drives without a map.
  virtual absl::Status Steer(const SteeringCommand& steering) = 0;
  // Zones of the navigator's map; null: none. All that moves it respects them
  // from the next step on, and a goal is planned anew; one that lies in what is
  // kept out of ends with kZone. FAILED_PRECONDITION: it drives without a map,
  // and so without zones.
  virtual absl::Status SetZones(
      std::shared_ptr<const zones::ZoneMap> zones) = 0;
  // What stands there and is not on the map, docks above all: lasers that see
  // it do not see another place. In the place of those told before; without a
  // map it means nothing.
  virtual void SetKnownThings(
      const std::shared_ptr<const localization::KnownThings>& /*things*/) {}
  // The robot is told where it is.
  virtual absl::Status SetPose(
      const core::LevelPose& pose,
      const localization::PoseCovariance2& covariance) = 0;
  // It is told that it does not know: it asks the server.
  virtual void FindYourself() = 0;
  // The robot stands from now on, whatever happens; for shutting down.
  virtual void Halt() = 0;

  virtual NavigatorMode mode() const = 0;
  virtual std::optional<GoalStatus> goal() const = 0;
  virtual NavigatorSnapshot Snapshot() const = 0;
  // Since the last call.
  virtual std::vector<NavigatorEvent> TakeEvents() = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NAVIGATOR_H_

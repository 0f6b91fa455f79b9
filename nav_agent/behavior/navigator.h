// The robot's mind: goals in, velocities out (thesis 6.5-6.6).
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/behavior/lost_and_found.h"
#include "nav_agent/behavior/navigator_limits.h"
#include "nav_agent/behavior/plan_runner.h"
#include "nav_agent/control/local_controller.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/core/navigation_cause.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/planning/global_planner.h"

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

enum class NavigatorMode : uint8_t {
  kIdle = 0,
  kPlanning = 1,
  kDriving = 2,
  kRecovering = 3,
  kLost = 4,          // stopped, about to ask
  kRelocalizing = 5,  // asks, looks around, confirms
  kPaused = 6,
  kSafeStop = 7,  // a device is lost; goes on by itself when it is back
  kNeedHelp = 8   // nobody found its place: waits to be told
};
const char* NavigatorModeName(NavigatorMode mode);

struct NavigationGoal {
  // Driven through in order, without a stop and whatever the heading there; the
  // last is the goal. Of a place only the level counts: its height is the
  // map's.
  std::vector<core::LevelPose> poses;
};

enum class GoalState : uint8_t {
  kAccepted = 0,
  kActive = 1,
  kSucceeded = 2,
  kFailed = 3,
  kCancelled = 4
};

struct GoalStatus {
  uint64_t id = 0;
  GoalState state = GoalState::kAccepted;
  core::NavigationCause cause = core::NavigationCause::kNone;
  std::string why;
  size_t next_pose = 0;
  double to_go_m = 0;
  double driven_m = 0;
  int replans = 0;
  int recoveries = 0;
};

struct NavigatorEvent {
  base::MonotonicTime stamp;
  // From 1 upwards, without gaps.
  uint64_t number = 0;
  // "goal", "plan", "blocked", "recovery", "lost", "fix", "stop", "resume",
  // "pose", "pause", "sensor", "deadline"; LostAndFound's "help", "check".
  std::string kind;
  std::string text;
};

// What became of a sensor's measurements.
struct SensorTally {
  int64_t used = 0;
  // Older than the device's timeout when they came; stamped in the future; not
  // newer than one that came before. None of them is used.
  int64_t late = 0;
  int64_t future = 0;
  int64_t out_of_order = 0;
  // Not finite, of another number of beams, or with hardly a range.
  int64_t broken = 0;
  // The same values as before, with another stamp.
  int64_t repeated = 0;
};

// What people and programs are shown. Copied under no lock: taken by the thread
// that steps.
struct NavigatorSnapshot {
  base::MonotonicTime stamp;
  NavigatorMode mode = NavigatorMode::kIdle;
  core::NavigationCause cause = core::NavigationCause::kNone;
  std::string cause_text;
  std::optional<localization::TrackedPose> pose;
  localization::LostVerdict verdict;
  std::optional<GoalStatus> goal;
  core::VelocityCommand command;
  std::vector<core::LevelPose> path;
  std::vector<geometry::Vec2> tree_edges;
  std::vector<control::Bubble> bubbles;
  std::vector<planning::Blockage> blockages;
  // The newest scan's end points in the map.
  std::vector<geometry::Vec2> scan_in_map;
  std::vector<localization::Particle> particles;
  control::CostmapView costmap;
  // The last answer of the server, and what became of it.
  std::optional<core::RelocalizationAnswer> fix;
  std::string fix_verdict;
  // What the search for the robot's place does.
  RecoveryState search = RecoveryState::kIdle;
  // The last frame that was sent to the server; null: none.
  std::shared_ptr<const core::RgbdFrame> query_frame;
  SensorTally laser;
  SensorTally rear_laser;
  SensorTally odometry;
  SensorTally camera;
  PlanTally plans;
  int64_t steps = 0;
  // Steps that came more than half a period late, and the longest time between
  // two.
  int64_t missed_deadlines = 0;
  double longest_step_gap_s = 0;
};

struct NavigatorOptions {
  traversability::NavigationMapOptions map;
  planning::GlobalPlannerOptions planner;
  // The first path is found within the first budget; the robot sets off, and a
  // better one is looked for within the second.
  planning::PlanBudget first_plan_budget = {.max_iterations = 2000};
  planning::PlanBudget plan_budget = {.max_iterations = 20000};
  // Plans are made by a thread of their own, so that Step never waits for one;
  // results then depend on the machine's speed.
  bool plans_in_background = false;
  // Or by such a thread, but handed over exactly so many steps after they were
  // begun (0 to 400; 0: not so), which Step waits for if it must: results do
  // not depend on the machine, and other than without both Step does nothing
  // of a plan's work. Not with plans_in_background.
  int plan_steps = 0;
  control::LocalControllerOptions control;
  localization::RobotTrackerOptions tracker;
  LostAndFoundOptions lost;
  NavigatorLimits limits;
  // Steps in a second (10 to 200).
  double control_hz = 40;
  // Devices that are silent for longer are lost (s, 0.05 to 5).
  double laser_timeout_s = 0.3;
  double odometry_timeout_s = 0.2;
  // Depth pictures in a second that obstacles are taken from (0 to 30; 0:
  // none). A lost robot takes them as often, at least once a second.
  double depth_hz = 5;
  // Whether a robot that was not told where it is looks for itself, rather than
  // waiting to be told.
  bool finds_itself_at_start = false;
  uint64_t seed = 0;

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
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
  virtual absl::StatusOr<uint64_t> SetGoal(const NavigationGoal& goal) = 0;
  // NOT_FOUND: that goal is not the current one. 0: whichever there is.
  virtual absl::Status CancelGoal(uint64_t id) = 0;
  virtual void Pause() = 0;
  virtual void Resume() = 0;
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

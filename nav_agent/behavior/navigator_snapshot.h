// What the supervisor shows of itself: its mode, its goal, its events.
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_SNAPSHOT_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_SNAPSHOT_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav_agent/behavior/planner_worker.h"
#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/control/local_controller.h"
#include "nav_agent/core/navigation_cause.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::behavior {

enum class NavigatorMode : uint8_t {
  kIdle = 0,
  kPlanning = 1,
  kDriving = 2,
  kRecovering = 3,
  kLost = 4,          // stopped, about to ask
  kRelocalizing = 5,  // asks, looks around, confirms
  kPaused = 6,
  kSafeStop = 7,  // a device is lost; goes on by itself when it is back
  kNeedHelp = 8,  // nobody found its place: waits to be told
  kStopped = 9,   // by somebody; stands until it is released
  kManual = 10    // driven by hand
};
const char* NavigatorModeName(NavigatorMode mode);

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
  // "pose", "pause", "sensor", "deadline", "release", "manual";
  // RelocalizationBehavior's "help", "check".
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

// A stop that holds until it is released.
struct OperatorStop {
  std::string why;
  base::MonotonicTime since;
};

// What people and programs are shown. Copied under no lock: taken by the thread
// that steps.
struct NavigatorSnapshot {
  base::MonotonicTime stamp;
  NavigatorMode mode = NavigatorMode::kIdle;
  core::NavigationCause cause = core::NavigationCause::kNone;
  std::string cause_text;
  // nullopt: nobody has stopped it.
  std::optional<OperatorStop> stop;
  std::optional<localization::TrackedPose> pose;
  localization::LostVerdict verdict;
  std::optional<GoalStatus> goal;
  core::VelocityCommand command;
  std::vector<core::LevelPose> path;
  std::vector<geometry::Vec2> tree_edges;
  std::vector<control::Bubble> bubbles;
  std::vector<planning::Blockage> blockages;
  // The newest scan's end points in the robot's base, and in the map.
  std::vector<geometry::Vec2> scan_in_base;
  std::vector<geometry::Vec2> scan_in_map;
  std::vector<localization::Particle> particles;
  control::CostmapView costmap;
  // The last answer of the server, and what became of it.
  std::optional<core::RelocalizationAnswer> fix;
  std::string fix_verdict;
  // What the search for the robot's place does.
  RelocalizationState search = RelocalizationState::kIdle;
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

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NAVIGATOR_SNAPSHOT_H_

// Between the thread that steps the robot and everybody else: commands go in,
// pictures of the robot come out, and nobody outside can make a step wait.
#ifndef NAV_AGENT_SERVICE_AGENT_HUB_H_
#define NAV_AGENT_SERVICE_AGENT_HUB_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/core/battery.h"
#include "nav_agent/routes/route_progress.h"
#include "nav_agent/service/dock_desk.h"

namespace treeline::agent_service {

struct DeviceReport {
  // "laser", "odometry", "base", "camera", "server".
  std::string name;
  // "starting", "running", "lost".
  std::string state;
  // Why it is not running; empty otherwise.
  std::string cause;

  bool operator==(const DeviceReport&) const = default;
};

// Something that was put into a simulated world, in the map (m).
struct ObstacleReport {
  std::string name;
  geometry::Vec2 center_in_map;
};

// The robot at one moment. Immutable once it is published.
struct AgentState {
  // Counts publications, from 1.
  uint64_t number = 0;
  // Since the agent's start (s).
  double time_s = 0;
  behavior::NavigatorSnapshot snapshot = {};
  // Of snapshot.goal.
  std::vector<core::LevelPose> goal_poses = {};
  std::vector<DeviceReport> devices = {};
  // Simulation only: where it truly is.
  std::optional<geometry::Rigid3> true_map_from_base = std::nullopt;
  std::vector<ObstacleReport> obstacles = {};
  int64_t missed_deadlines = 0;
  // nullopt: the robot does not tell.
  std::optional<core::Battery> battery = std::nullopt;
  // ZoneBook's.
  uint64_t zones_revision = 0;
  // Under way, or the last; whether a restart finds it; and RouteBook's
  // revision, with each route that begins counted, too.
  std::optional<routes::RouteStatus> route = std::nullopt;
  absl::Status route_keeping = {};
  uint64_t routes_revision = 0;
  DockReport docks = {};
};

struct AgentHubOptions {
  // Commands that wait for the next step, 1..10000.
  int max_commands = 64;
  // Of them, so many are run in one step, 1..max_commands.
  int commands_in_step = 8;
  // For how long a command waits for the step (1 ms..1 min).
  absl::Duration patience = absl::Seconds(2);
  // Events that are kept for those who ask late, 1..1000000.
  int max_events = 1000;

  absl::Status Validate() const;
};

// Thread-safe. RunCommands, Publish and AddEvents by the stepping thread.
class AgentHub {
 public:
  using Command = std::function<absl::Status(behavior::Navigator&)>;

  // `options` must be valid.
  explicit AgentHub(const AgentHubOptions& options) : options_(options) {}

  // ---- everybody else ----
  // Has the stepping thread run `command`, and waits for what it says. After
  // this has returned the command does not run any more. RESOURCE_EXHAUSTED:
  // too many wait; DEADLINE_EXCEEDED: no step took it in time; UNAVAILABLE:
  // closed. Urgent ones come first, however many wait.
  absl::Status Do(Command command, bool is_urgent = false);

  // Commands that no step has taken yet.
  size_t waiting() const;

  // The newest picture; null before the first.
  std::shared_ptr<const AgentState> Latest() const;
  // One that is newer than `number`, as soon as there is one. Null if there is
  // none until `deadline`, or the hub is closed.
  std::shared_ptr<const AgentState> WaitForNewer(uint64_t number,
                                                 absl::Time deadline) const;

  struct Event {
    uint64_t number = 0;
    double time_s = 0;
    std::string kind;
    std::string text;
  };
  // Those after `number`, oldest first, at most `at_most` of them. What was
  // too long ago is left out.
  std::vector<Event> EventsAfter(uint64_t number, size_t at_most) const;
  uint64_t last_event() const;

  // Whoever waits is told so, and nothing new is accepted.
  void Close();
  bool is_closed() const;

  // ---- the thread that steps ----
  // Runs what waits. Never waits itself, but for the lock.
  void RunCommands(behavior::Navigator& navigator);
  // state.number is set here.
  void Publish(AgentState state);
  // Numbers are set here.
  void AddEvent(double time_s, const std::string& kind,
                const std::string& text);

 private:
  struct Waiting {
    Command command;
    bool is_urgent = false;
    bool is_started = false;
    bool is_done = false;
    absl::Status result;
  };

  const AgentHubOptions options_;
  mutable absl::Mutex mutex_;
  // A command was done, or the hub is closed.
  mutable absl::CondVar done_;
  // There is a newer state, or the hub is closed.
  mutable absl::CondVar newer_;
  std::deque<std::shared_ptr<Waiting>> commands_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const AgentState> latest_ ABSL_GUARDED_BY(mutex_);
  std::deque<Event> events_ ABSL_GUARDED_BY(mutex_);
  uint64_t last_event_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_AGENT_HUB_H_

// What may be asked of a robot, checked; for gRPC and HTTP alike.
#ifndef NAV_AGENT_SERVICE_AGENT_COMMANDS_H_
#define NAV_AGENT_SERVICE_AGENT_COMMANDS_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/agent_info.h"
#include "nav_agent/service/dock_desk.h"
#include "nav_agent/service/driver_seat.h"
#include "nav_agent/service/route_desk.h"
#include "nav_agent/service/simulation_control.h"
#include "nav_agent/service/stop_file.h"
#include "nav_agent/service/zone_book.h"

namespace treeline::agent_service {

// A pose as people give it.
struct RequestedPose {
  // In the map (m, rad).
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
  int level = 0;
};

inline constexpr size_t kMaxGoalPoses = 100;
inline constexpr size_t kMaxWhyBytes = 200;

// Of a stop, or a release, that was done.
struct StopKeeping {
  // OK: a restart finds it; else what is wrong.
  absl::Status status;
};

// Thread-safe. Errors beside those below: as AgentHub::Do, and what the
// navigator or the simulation says.
class AgentCommands {
 public:
  // simulation: null for a real robot. stops, zones, routes, docks: null if no
  // restart is to find them. All must outlive it.
  AgentCommands(AgentHub& hub, const AgentInfo& info,
                SimulationControl* simulation, StopFile* stops = nullptr,
                ZoneBook* zones = nullptr, RouteDesk* routes = nullptr,
                DockDesk* docks = nullptr)
      : hub_(hub),
        info_(info),
        simulation_(simulation),
        stops_(stops == nullptr ? forgotten_ : *stops),
        unkept_zones_(info.map),
        zones_(zones == nullptr ? unkept_zones_ : *zones),
        unkept_routes_(static_cast<int>(info.map->levels.levels.size())),
        routes_(routes == nullptr ? unkept_routes_ : *routes),
        unkept_docks_(std::make_unique<DockBook>(info.map), info.robot, {}),
        docks_(docks == nullptr ? unkept_docks_ : *docks) {}

  // Any thread. INVALID_ARGUMENT: none or too many, not finite, absurdly far,
  // or no such level, and which there are.
  absl::StatusOr<uint64_t> SetGoal(const std::vector<RequestedPose>& poses);
  // 0: whichever goal there is, or docking, or route. These end with their
  // goals.
  absl::Status Cancel(uint64_t goal_id);
  absl::Status Pause();
  // And a route that is held goes on, unless another goal or a docking is under
  // way; and the robot may go to charge.
  absl::Status Resume();
  // The robot stands from the next step on. The error is of that; what is wrong
  // with keeping the stop is in the answer. INVALID_ARGUMENT: longer than
  // kMaxWhyBytes.
  absl::StatusOr<StopKeeping> Stop(const std::string& why);
  // FAILED_PRECONDITION: it was stopped again meanwhile. The answer: what is
  // wrong with keeping that.
  absl::StatusOr<StopKeeping> Release();
  // As ManualDrive and DriverSeat have it. DEADLINE_EXCEEDED: no step took it
  // before it was stale.
  absl::Status Drive(const core::VelocityCommand& wanted,
                     const std::string& driver, uint64_t sequence);
  // As ZoneBook's.
  absl::StatusOr<ZoneBookContents> PutZones(
      const std::vector<zones::Zone>& zones);
  absl::StatusOr<ZoneBookContents> RemoveZones(
      const std::vector<std::string>& names);
  const ZoneBook& zones() const { return zones_; }
  // As NavigationService's RunRoute has it, ResumeRoute and CancelRoute. 0:
  // whichever route there is.
  absl::StatusOr<uint64_t> RunRoute(routes::Route route, size_t first_waypoint);
  absl::Status ResumeRoute();
  absl::Status CancelRoute(uint64_t route_id = 0);
  // For its book, and for the stepping thread its runner.
  RouteDesk& routes() { return routes_; }
  const RouteDesk& routes() const { return routes_; }
  // As DockingService has it. An empty name: the nearest. 0: whichever docking
  // there is.
  absl::StatusOr<uint64_t> Dock(const std::string& name);
  absl::Status Undock();
  absl::Status CancelDocking(uint64_t id = 0);
  // FAILED_PRECONDITION: it does not know.
  absl::StatusOr<core::LevelPose> WhereItStands() const;
  DockDesk& docks() { return docks_; }
  const DockDesk& docks() const { return docks_; }
  // Standard deviations (m, rad), in (0, 100]; INVALID_ARGUMENT otherwise.
  absl::Status SetPose(const RequestedPose& pose, double std_m, double std_rad);
  absl::Status FindYourself();

  // UNIMPLEMENTED: the robot is real.
  absl::StatusOr<geometry::Rigid3> Kidnap(const RequestedPose& pose);
  absl::StatusOr<geometry::Rigid3> KidnapTo(const std::string& place);
  absl::StatusOr<geometry::Rigid3> KidnapAnywhere();
  // size_m: in [0.1, 3].
  absl::StatusOr<std::string> AddObstacle(const RequestedPose& pose,
                                          double size_m);
  absl::Status RemoveObstacle(const std::string& name);
  absl::Status InjectFault(const RequestedFault& fault);

  // For the stepping thread, and before anything steps: as SetGoal and SetPose;
  // and the stop that was kept.
  void StopAsKept(behavior::Navigator& navigator);
  // For the stepping thread: after each step of the navigator; and into what is
  // published.
  void StepRoute(behavior::Navigator& navigator, base::MonotonicTime now);
  void ShowRoute(AgentState& state);
  // The same of docks, after StepRoute.
  void StepDocks(behavior::Navigator& navigator, base::MonotonicTime now,
                 const std::optional<core::Battery>& battery);
  absl::StatusOr<uint64_t> SetGoalNow(behavior::Navigator& navigator,
                                      const std::vector<RequestedPose>& poses);
  static absl::Status SetPoseNow(behavior::Navigator& navigator,
                                 const core::LevelPose& pose, double std_m,
                                 double std_rad);
  // On the ground of its level; `what` names it in errors.
  absl::StatusOr<core::LevelPose> OnLevel(const RequestedPose& pose,
                                          const std::string& what) const;
  // On the ground that is nearest in height.
  core::LevelPose NearestLevel(const geometry::Rigid3& map_from_base) const;
  // The poses of a goal that was set here; none if it is long ago.
  std::vector<core::LevelPose> PosesOf(uint64_t goal_id) const;

  const AgentInfo& info() const { return info_; }
  AgentHub& hub() { return hub_; }
  bool is_simulated() const { return simulation_ != nullptr; }

 private:
  absl::StatusOr<geometry::Rigid3> DoKidnap(
      const std::function<absl::StatusOr<geometry::Rigid3>(SimulationControl&)>&
          kidnap);
  absl::Status CheckSimulated() const;
  absl::StatusOr<uint64_t> DockNow(behavior::Navigator& navigator,
                                   const std::string& name);
  // What PosesOf knows of a goal that was set above the navigator.
  void NoteTarget(uint64_t goal_id, const core::LevelPose& target);
  absl::Status ApplyZones(const std::shared_ptr<const zones::ZoneMap>& zones);

  AgentHub& hub_;
  const AgentInfo& info_;
  SimulationControl* const simulation_;
  StopFile forgotten_;
  StopFile& stops_;
  ZoneBook unkept_zones_;
  ZoneBook& zones_;
  RouteDesk unkept_routes_;
  RouteDesk& routes_;
  DockDesk unkept_docks_;
  DockDesk& docks_;
  const base::SteadyClock real_clock_;
  // Stops so far: one during a release ends it.
  std::atomic<int64_t> stopped_ = 0;
  DriverSeat seat_;
  mutable absl::Mutex mutex_;
  // The newest goal.
  uint64_t goal_id_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<core::LevelPose> goal_poses_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_AGENT_COMMANDS_H_

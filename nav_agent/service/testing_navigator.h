// A navigator without a robot, for tests of what stands around it.
#ifndef NAV_AGENT_SERVICE_TESTING_NAVIGATOR_H_
#define NAV_AGENT_SERVICE_TESTING_NAVIGATOR_H_

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/service/agent_commands.h"

namespace treeline::agent_service {

// Drives straight to its goal, 0.1 m a step. Snapshots are of what was set.
class FakeNavigator final : public behavior::Navigator {
 public:
  void Step() override;
  absl::StatusOr<uint64_t> SetGoal(
      const behavior::NavigationGoal& goal) override;
  absl::Status CancelGoal(uint64_t id) override;
  void Pause() override { snapshot.mode = behavior::NavigatorMode::kPaused; }
  void Resume() override { snapshot.mode = behavior::NavigatorMode::kIdle; }
  void Stop(const std::string& why) override;
  void Release() override;
  absl::Status Drive(const core::VelocityCommand& wanted) override;
  absl::Status Steer(const behavior::SteeringCommand& steering) override;
  absl::Status SetZones(std::shared_ptr<const zones::ZoneMap> told) override {
    zones = std::move(told);
    return absl::OkStatus();
  }
  absl::Status SetPose(
      const core::LevelPose& pose,
      const localization::PoseCovariance2& covariance) override;
  void FindYourself() override {
    snapshot.mode = behavior::NavigatorMode::kRelocalizing;
  }
  void Halt() override { halted = true; }
  behavior::NavigatorMode mode() const override { return snapshot.mode; }
  std::optional<behavior::GoalStatus> goal() const override {
    return snapshot.goal;
  }
  behavior::NavigatorSnapshot Snapshot() const override { return snapshot; }
  std::vector<behavior::NavigatorEvent> TakeEvents() override { return {}; }

  behavior::NavigatorSnapshot snapshot;
  behavior::NavigationGoal last_goal;
  std::shared_ptr<const zones::ZoneMap> zones;
  bool halted = false;
  // While false it stands before its goal: for whoever wants to see it on the
  // way there. Thread-safe.
  std::atomic<bool> may_arrive = true;

 private:
  uint64_t goals_ = 0;
};

// A simulation that remembers what it was told.
class FakeSimulation final : public SimulationControl {
 public:
  absl::StatusOr<geometry::Rigid3> Kidnap(const core::LevelPose& pose) override;
  absl::StatusOr<geometry::Rigid3> KidnapTo(const std::string& place) override;
  absl::StatusOr<geometry::Rigid3> KidnapAnywhere() override;
  absl::StatusOr<std::string> AddObstacle(const core::LevelPose& pose,
                                          double size_m) override;
  absl::Status RemoveObstacle(const std::string& name) override;
  absl::Status InjectFault(const RequestedFault& fault) override;

  std::vector<std::string> calls;
};

// Two levels of 4 x 3 m: the lower at 0 m with a wall in its middle column, the
// upper at 1 m.
std::shared_ptr<const behavior::NavigatorMap> TwoLevelMap();
AgentInfo TestInfo();

// An agent that steps in a thread of its own, as fast as it is looked at.
class SteppingAgent {
 public:
  explicit SteppingAgent(bool is_simulated = true,
                         const AgentHubOptions& options = {});
  // Closes the hub, too.
  ~SteppingAgent();

  void Close();

  AgentInfo info = TestInfo();
  AgentHub hub;
  FakeSimulation simulation;
  AgentCommands commands;
  FakeNavigator navigator;

 private:
  const base::SteadyClock clock_;
  std::jthread thread_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_TESTING_NAVIGATOR_H_

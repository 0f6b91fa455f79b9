// A robot that moves as it is told, above a navigator of parts, for tests.
#ifndef NAV_AGENT_DOCKING_TESTING_DOCK_ROBOT_H_
#define NAV_AGENT_DOCKING_TESTING_DOCK_ROBOT_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_navigator.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/docking/charge_keeper.h"
#include "nav_agent/docking/dock_pilot.h"
#include "nav_agent/routes/route_runner.h"

namespace treeline::docking {

// Goals are reached at once, `beside` what they ask for.
class DockFixture : public behavior::NavigatorFixture {
 protected:
  static Dock Charger(const std::string& name = "charger") {
    return {.name = name, .map_from_docked = {{5, 5}, 0}, .staging_m = 0.85};
  }
  void SetDocks(std::vector<Dock> docks) {
    pilot.SetDocks(std::make_shared<const std::vector<Dock>>(std::move(docks)));
  }
  void Begin(const Dock& dock) {
    const absl::StatusOr<uint64_t> begun = pilot.Begin(*navigator, dock);
    ASSERT_TRUE(begun.ok()) << begun.status();
  }
  // All that stands above the navigator; the robot moves as it is told.
  void Drive(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / kStep_s + 0.5); ++i) {
      Run(kStep_s);
      Move();
      if (arrives) ArriveAtGoal();
      runner.Step(*navigator, clock.Now());
      keeper.Step(*navigator, pilot, runner, clock.Now(), battery);
      pilot.Step(*navigator, clock.Now(), battery);
      for (const auto& source : {pilot.TakeEvents(), keeper.TakeEvents()}) {
        events.insert(events.end(), source.begin(), source.end());
      }
      if (on_step) on_step();
    }
  }
  // Until there is nothing more to do, or for too long.
  void DriveUntilOver() {
    for (int i = 0; i < 400 && pilot.IsUnderWay(); ++i) Drive(0.5);
  }
  void Put(const geometry::Rigid2& map_from_base) {
    tracker->pose = behavior::PoseAtPoint(map_from_base.translation.x,
                                          map_from_base.translation.y);
    tracker->pose->map_from_base.yaw_rad = map_from_base.yaw_rad;
  }
  DockOffset Off(const Dock& dock) {
    return OffsetFrom(dock, tracker->pose->map_from_base);
  }
  const DockingStatus& status() { return pilot.status(); }

  DockPilot pilot{core::RobotModel{}};
  routes::RouteRunner runner;
  ChargeKeeper keeper{ChargeOptions{}};
  std::optional<core::Battery> battery;
  bool arrives = true;
  geometry::Rigid2 beside;
  std::function<void()> on_step;

 private:
  void Move() {
    if (!tracker->pose.has_value() || base.commands.empty()) return;
    const core::VelocityCommand& command = base.commands.back();
    // What the controller says of goals is not meant for wheels.
    if (command == controller->result.command) return;
    tracker->pose->map_from_base =
        tracker->pose->map_from_base * control::MotionIn(kStep_s, command);
  }
  void ArriveAtGoal() {
    if (mode() != behavior::NavigatorMode::kDriving ||
        controller->path.empty()) {
      controller->result.state = control::ControlState::kDriving;
      return;
    }
    tracker->pose->map_from_base =
        controller->path.back().map_from_base * beside;
    controller->result.state = control::ControlState::kArrived;
  }
};

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_TESTING_DOCK_ROBOT_H_

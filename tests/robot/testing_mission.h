// A navigator that drives a simulated robot over a world's perfect map: for
// tests of the whole loop.
#ifndef TESTS_ROBOT_TESTING_MISSION_H_
#define TESTS_ROBOT_TESTING_MISSION_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nav_agent/behavior/navigator.h"
#include "simulation/simulator/simulator.h"
#include "simulation/worlds/world.h"
#include "tests/robot/testing_lost_robot.h"

namespace treeline {

struct TestMissionOptions {
  std::string world = "cafe";
  geometry::Vec2 start = {1.6, 7.9};
  double yaw_rad = 0;
  uint64_t seed = 1000;
  simulator::WheelOdometryErrors errors = {};
  behavior::NavigatorOptions navigator = {};
  bool is_told_its_pose = true;
  // Whether it has a camera, whose pictures nobody looks at, and a server that
  // answers with the truth.
  bool has_server = false;
};

// Pictures of nothing, ten a second.
class BlankCamera final : public core::RgbdCamera {
 public:
  explicit BlankCamera(const base::Clock& clock) : clock_(clock) {}
  camera::RgbdCalibration Calibration() const override { return {}; }
  std::vector<core::RgbdFrame> TakeFrames() override;
  core::DeviceHealth Health() const override;

 private:
  const base::Clock& clock_;
  int64_t frames_ = 0;
};

class TestMission {
 public:
  // Fails the test, and leaves an object that must not be used, if there is no
  // such world.
  explicit TestMission(const TestMissionOptions& options);

  // Simulated time passes; `each`, if given, is called after each step.
  void Run(double seconds, const std::function<void()>& each = nullptr);
  // Until the goal has ended, or so much time has passed.
  behavior::GoalStatus RunToEnd(double max_s,
                                const std::function<void()>& each = nullptr);
  // Until `done`; whether it came to be.
  bool RunUntil(const std::function<bool()>& done, double max_s);

  uint64_t Send(std::vector<core::LevelPose> poses);
  core::LevelPose At(double x_m, double y_m, double yaw_rad = 0,
                     int level = 0) const;
  // On the ground nearest to that height.
  core::LevelPose Near(double x_m, double y_m, double yaw_rad,
                       double height_m) const;

  simulator::Simulator& simulator() { return *simulator_; }
  behavior::Navigator& navigator() { return *navigator_; }
  // With has_server.
  ScriptedServer& server() { return *server_; }
  const traversability::NavigationMap& map() const { return *map_; }
  geometry::Rigid2 Truth() const;
  // How far the estimate is from the truth (m).
  double Error_m() const;
  // All that happened so far.
  const std::vector<behavior::NavigatorEvent>& events() const {
    return events_;
  }
  bool HasEvent(const std::string& kind, const std::string& part) const;
  std::string Story() const;
  // Collisions, falls and stairs: none are to be.
  const std::vector<simulator::SimEvent>& mishaps() const { return mishaps_; }
  // Since the last call, the fastest the robot truly went (m/s).
  double TakeTopSpeed_mps();

 private:
  void MakeServer();

  std::shared_ptr<const traversability::NavigationMap> map_;
  std::unique_ptr<simulator::Simulator> simulator_;
  std::unique_ptr<BlankCamera> camera_;
  std::unique_ptr<ScriptedServer> server_;
  std::unique_ptr<behavior::Navigator> navigator_;
  std::vector<behavior::NavigatorEvent> events_;
  std::vector<simulator::SimEvent> mishaps_;
  double top_speed_mps_ = 0;
};

}  // namespace treeline

#endif  // TESTS_ROBOT_TESTING_MISSION_H_

// A navigator that drives a simulated robot over a world's perfect map: for
// tests of the whole loop.
#ifndef NAV_AGENT_APP_TESTING_MISSION_H_
#define NAV_AGENT_APP_TESTING_MISSION_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/synthetic/world.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/sim/simulator.h"

namespace treeline {

struct TestMissionOptions {
  std::string world = "cafe";
  Vec2 start = {1.6, 7.9};
  double yaw_rad = 0;
  uint64_t seed = 1000;
  DriveErrors errors = {};
  NavigatorOptions navigator = {};
  // Null: none.
  RelocalizationPort* server = nullptr;
  RgbdCamera* camera = nullptr;
  bool is_told_its_pose = true;
};

class TestMission {
 public:
  // Fails the test, and leaves an object that must not be used, if there is no
  // such world.
  explicit TestMission(const TestMissionOptions& options);

  // Simulated time passes; `each`, if given, is called after each step.
  void Run(double seconds, const std::function<void()>& each = nullptr);
  // Until the goal has ended, or so much time has passed.
  GoalStatus RunToEnd(double most_s,
                      const std::function<void()>& each = nullptr);
  // Until `done`; whether it came to be.
  bool RunUntil(const std::function<bool()>& done, double most_s);

  uint64_t Send(std::vector<LevelPose> poses);
  LevelPose At(double x_m, double y_m, double yaw_rad = 0, int level = 0) const;
  // On the ground nearest to that height.
  LevelPose Near(double x_m, double y_m, double yaw_rad, double height_m) const;

  Simulator& simulator() { return *simulator_; }
  Navigator& navigator() { return *navigator_; }
  const NavigationMap& map() const { return *map_; }
  Rigid2 Truth() const;
  // How far the estimate is from the truth (m).
  double Error_m() const;
  // All that happened so far.
  const std::vector<NavigatorEvent>& events() const { return events_; }
  bool HasEvent(const std::string& kind, const std::string& part) const;
  std::string Story() const;
  // Collisions, falls and stairs: none are to be.
  const std::vector<SimEvent>& mishaps() const { return mishaps_; }
  // Since the last call, the fastest the robot truly went (m/s).
  double TakeTopSpeed_mps();

 private:
  std::shared_ptr<const NavigationMap> map_;
  std::unique_ptr<Simulator> simulator_;
  std::unique_ptr<Navigator> navigator_;
  std::vector<NavigatorEvent> events_;
  std::vector<SimEvent> mishaps_;
  double top_speed_mps_ = 0;
};

}  // namespace treeline

#endif  // NAV_AGENT_APP_TESTING_MISSION_H_

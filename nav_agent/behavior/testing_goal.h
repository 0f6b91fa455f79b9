// What tests of a goal's states are made of: a planner and a controller that do
// as they are told, and a goal on open ground.
#ifndef NAV_AGENT_BEHAVIOR_TESTING_GOAL_H_
#define NAV_AGENT_BEHAVIOR_TESTING_GOAL_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "gtest/gtest.h"
#include "nav_agent/behavior/goal_course.h"
#include "nav_agent/behavior/goal_tools.h"
#include "nav_agent/behavior/testing_devices.h"
#include "nav_agent/behavior/testing_parts.h"

namespace treeline::behavior {

class GoalFixture : public testing::Test {
 protected:
  // A goal of these poses.
  static GoalCourse CourseTo(std::vector<core::LevelPose> poses) {
    GoalCourse course;
    course.goal.poses = std::move(poses);
    return course;
  }
  static control::ControlPose Robot(double x_m, double y_m,
                                    double yaw_rad = 0) {
    control::ControlPose pose;
    pose.pose = PoseAtPoint(x_m, y_m, yaw_rad);
    return pose;
  }
  static PlannedPath Straight(const core::LevelPose& from,
                              const core::LevelPose& to) {
    PlannedPath path;
    path.result = FakePlannerWorker::Straight(from, to);
    return path;
  }
  void Answer(absl::StatusOr<planning::PlanResult> answer) {
    planner.answers.push_back(std::move(answer));
  }
  void AnswerFailure(core::NavigationCause cause, std::string why = "so") {
    Answer(FakePlannerWorker::Failure(cause, std::move(why)));
  }
  void Block(geometry::Vec2 center) {
    tools.blockages.Add({.center = center, .radius_m = 0.3, .level = 0}, Now());
  }
  base::MonotonicTime Now() const { return clock.Now(); }
  // Since the last call: whether there was an event of this kind with `part`.
  bool Said(const std::string& kind, const std::string& part) {
    bool said = false;
    for (const NavigatorEvent& event : events.Take()) {
      said =
          said || (event.kind == kind && absl::StrContains(event.text, part));
    }
    return said;
  }

  ManualClock clock;
  FakePlannerWorker planner;
  FakeController controller;
  EventLog events;
  NavigatorOptions options;
  GoalTools tools{OpenMap(), planner, controller, options, events};
  GoalCourse goal = CourseTo({PoseAtPoint(5, 2)});
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_TESTING_GOAL_H_

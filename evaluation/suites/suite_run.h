// What every run of a suite comes to, whatever it was for.
#ifndef EVALUATION_SUITES_SUITE_RUN_H_
#define EVALUATION_SUITES_SUITE_RUN_H_

#include <cstdint>
#include <string>
#include <vector>

#include "evaluation/suites/suite_robot.h"
#include "simulation/runs/plan_picture.h"

namespace treeline::suites {

struct SuiteRun {
  std::string world;
  uint64_t seed = 0;
  core::NavigationCause cause = core::NavigationCause::kNone;
  std::string why;
  double simulated_s = 0;
  double driven_m = 0;
  int collisions_of_robot = 0;
  int collisions = 0;
  int stair_entries = 0;
  int edge_entries = 0;
  StepTimes times;
  // For the picture and the log of a run that failed.
  runs::SimulationResult record;
  std::vector<behavior::NavigatorEvent> events;
  runs::PlanMarks marks;

  // It ran into nothing, and neither got onto stairs nor fell.
  bool IsSafe() const {
    return collisions_of_robot == 0 && stair_entries == 0 && edge_entries == 0;
  }
};

// Whether nothing more comes of the goal.
bool IsOver(const behavior::GoalStatus& goal);

// All of the above, as the robot and its world now are; cause and why are the
// navigator's. goal: in the world.
void Summarize(const SuiteRobot& robot, const simulator::RobotPlacement& goal,
               SuiteRun& run);

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_RUN_H_

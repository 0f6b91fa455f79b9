#include "evaluation/suites/suite_run.h"

#include "common/geometry/planar_pose.h"

namespace treeline::suites {
namespace {

// What the robot planned and where it thinks that it is, in the world.
runs::PlanMarks MarksOf(const SuitePlace& place,
                        const behavior::NavigatorSnapshot& snapshot,
                        const simulator::RobotPlacement& goal,
                        const geometry::Rigid3& world_from_base) {
  runs::PlanMarks marks;
  marks.goal = geometry::Rigid2{goal.position, goal.yaw_rad};
  for (const core::LevelPose& pose : snapshot.path) {
    marks.path.push_back(
        place.InWorld(pose.map_from_base.translation, pose.place.height_m));
  }
  if (snapshot.pose.has_value()) {
    const core::LevelPose& pose = snapshot.pose->pose;
    const geometry::Vec3 at =
        place.InWorld(pose.map_from_base.translation, pose.place.height_m);
    marks.estimate = geometry::Rigid2{
        {at.x, at.y},
        pose.map_from_base.yaw_rad -
            geometry::PlanarPose(place.map_from_world()).yaw_rad};
  }
  marks.truth = geometry::PlanarPose(world_from_base);
  return marks;
}

}  // namespace

bool IsOver(const behavior::GoalStatus& goal) {
  return goal.state == behavior::GoalState::kSucceeded ||
         goal.state == behavior::GoalState::kFailed ||
         goal.state == behavior::GoalState::kCancelled;
}

void Summarize(const SuiteRobot& robot, const simulator::RobotPlacement& goal,
               SuiteRun& run) {
  run.record = robot.record();
  run.events = robot.navigator_events();
  run.times = robot.step_times();
  run.world = run.record.world;
  run.seed = run.record.seed;
  run.simulated_s = run.record.simulated_s;
  run.driven_m = run.record.final_state.distance_m;
  run.collisions = run.record.Count(simulator::SimEventKind::kCollision);
  run.collisions_of_robot = run.record.CollisionsOfRobot();
  run.stair_entries = run.record.Count(simulator::SimEventKind::kStairs);
  run.edge_entries = run.record.Count(simulator::SimEventKind::kFall) +
                     run.record.Count(simulator::SimEventKind::kTipped);
  const behavior::NavigatorSnapshot snapshot = robot.navigator().Snapshot();
  run.marks = MarksOf(robot.place(), snapshot, goal,
                      run.record.final_state.world_from_base);
  run.cause = snapshot.cause;
  run.why = snapshot.cause_text;
}

}  // namespace treeline::suites

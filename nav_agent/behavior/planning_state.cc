#include "nav_agent/behavior/planning_state.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/place_text.h"
#include "nav_agent/behavior/pose_lists.h"

namespace treeline::behavior {
namespace {

// What follows from a plan that failed, where nothing but the map is in the
// way.
PlanningState::Outcome OfFailure(const planning::PlanResult& failure,
                                 const GoalCourse& goal,
                                 const core::LevelPose& robot) {
  std::string why = absl::StrCat(
      failure.why.empty() ? "no way was found" : failure.why, ", from ",
      PlaceText(robot), " to ", PlaceText(goal.Target()));
  switch (failure.failure) {
    case core::NavigationCause::kNone:
      return GoalEnd{.state = GoalState::kFailed,
                     .cause = core::NavigationCause::kInternal,
                     .why = "the planner found an empty path"};
    case core::NavigationCause::kStartBlocked:
      return GoalTrouble{.kind = Trouble::kEnclosed,
                         .cause = failure.failure,
                         .why = std::move(why)};
    case core::NavigationCause::kPlanTimeout:
      return GoalTrouble{.kind = Trouble::kNoWay,
                         .cause = failure.failure,
                         .why = std::move(why)};
    case core::NavigationCause::kNoPath:
      if (goal.is_first_path) break;
      // Its way led here: a little off, or turned, one leads on.
      return GoalTrouble{.kind = Trouble::kNoWay,
                         .cause = failure.failure,
                         .why = std::move(why)};
    default:
      break;
  }
  return GoalEnd{.state = GoalState::kFailed,
                 .cause = failure.failure,
                 .why = std::move(why)};
}

// Whether something that was met stands on the goal, or so near that the robot
// has no room there.
bool IsOccupied(const GoalCourse& goal, const ObstacleMemory& blockages) {
  if (!goal.IsLastLeg()) return false;
  const core::LevelPose& target = goal.Target();
  return std::ranges::any_of(
      blockages.All(), [&target](const planning::Blockage& blockage) {
        return blockage.level == target.place.level &&
               geometry::Norm(blockage.center -
                              target.map_from_base.translation) <=
                   kObstacleNear_m;
      });
}

// There is a way, but for what stands about.
PlanningState::Outcome OfBlockage(const planning::PlanResult& failure,
                                  const GoalCourse& goal,
                                  const core::LevelPose& robot,
                                  GoalTools& tools, base::MonotonicTime now) {
  if (failure.failure == core::NavigationCause::kStartBlocked ||
      !IsOccupied(goal, tools.blockages)) {
    return GoalTrouble{
        .kind = failure.failure == core::NavigationCause::kStartBlocked
                    ? Trouble::kEnclosed
                    : Trouble::kNoWay,
        .cause = core::NavigationCause::kBlocked,
        .why = absl::StrCat("what stands in the way leaves no other: ",
                            failure.why)};
  }
  if (!tools.occupied.HasWaited(now)) {
    return GoalTrouble{.kind = Trouble::kOccupied,
                       .cause = core::NavigationCause::kGoalBlocked,
                       .why = "something stands on the goal"};
  }
  return GoalEnd{
      .state = GoalState::kFailed,
      .cause = core::NavigationCause::kGoalBlocked,
      .why = absl::StrFormat("the goal is occupied: stopped %.2f m beside it",
                             Distance_m(robot, goal.Target()))};
}

}  // namespace

PlanningState::PlanningState(const GoalCourse& goal,
                             const core::LevelPose& robot, GoalTools& tools,
                             base::MonotonicTime now) {
  tools.plans.Ask(PlanPurpose::kRoute, robot, goal.Target(),
                  tools.blockages.All(), now);
}

PlanningState::Outcome PlanningState::Step(const GoalCourse& goal,
                                           const core::LevelPose& robot,
                                           GoalTools& tools,
                                           base::MonotonicTime now) {
  // A plan that fails may ask for another one, which may be there at once. That
  // ends: each is asked for another purpose, and none twice but where the way
  // was freed, which happens between steps.
  while (std::optional<PlanRequests::Answer> answer =
             tools.plans.TakeInTime(now)) {
    std::optional<Outcome> outcome =
        TakeAnswer(*std::move(answer), goal, robot, tools, now);
    if (outcome.has_value()) return *std::move(outcome);
  }
  return {};
}

std::optional<PlanningState::Outcome> PlanningState::TakeAnswer(
    PlanRequests::Answer answer, const GoalCourse& goal,
    const core::LevelPose& robot, GoalTools& tools, base::MonotonicTime now) {
  if (!answer.result.ok()) {
    return GoalEnd{
        .state = GoalState::kFailed,
        .cause = core::NavigationCause::kInternal,
        .why = absl::StrCat("the planner: ", answer.result.status().message())};
  }
  const PlanPurpose purpose = answer.purpose;
  if (answer.HasPath() && purpose != PlanPurpose::kUnblocked) {
    return PlannedPath{.result = *std::move(answer.result),
                       .had_blockages = answer.had_blockages,
                       .may_be_better = purpose == PlanPurpose::kRoute};
  }
  if (std::exchange(way_is_free_, false)) {
    tools.plans.Ask(PlanPurpose::kRoute, robot, goal.Target(),
                    tools.blockages.All(), now);
    return std::nullopt;
  }
  if (answer.HasPath()) return OfBlockage(failure_, goal, robot, tools, now);
  if (purpose == PlanPurpose::kRoute &&
      answer.result->failure == core::NavigationCause::kPlanTimeout) {
    tools.plans.Ask(PlanPurpose::kFullRoute, robot, goal.Target(),
                    tools.blockages.All(), now);
    return std::nullopt;
  }
  // What stood about may have faded meanwhile.
  if (answer.had_blockages) {
    failure_ = *std::move(answer.result);
    tools.plans.Ask(PlanPurpose::kUnblocked, robot, goal.Target(), {}, now);
    return std::nullopt;
  }
  return OfFailure(*answer.result, goal, robot);
}

}  // namespace treeline::behavior

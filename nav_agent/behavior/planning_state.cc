#include "nav_agent/behavior/planning_state.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "nav_agent/behavior/place_text.h"

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
  if (answer.HasPath()) {
    return GoalTrouble{
        .kind = failure_.failure == core::NavigationCause::kStartBlocked
                    ? Trouble::kEnclosed
                    : Trouble::kNoWay,
        .cause = core::NavigationCause::kBlocked,
        .why = absl::StrCat("what stands in the way leaves no other: ",
                            failure_.why)};
  }
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

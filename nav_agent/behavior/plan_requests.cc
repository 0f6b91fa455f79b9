#include "nav_agent/behavior/plan_requests.h"

#include <utility>

#include "common/base/clock.h"
#include "common/base/random.h"

namespace treeline::behavior {

void PlanRequests::Ask(PlanPurpose purpose, const core::LevelPose& from,
                       const core::LevelPose& to,
                       std::vector<planning::Blockage> blockages,
                       base::MonotonicTime now) {
  planning::PlanRequest request = {.start = from,
                                   .goal = to,
                                   .blockages = {},
                                   .seed = base::MixBits(seed_ + ++plans_),
                                   .zones = zones_,
                                   .freed = freed_};
  if (purpose != PlanPurpose::kUnblocked) {
    request.blockages = std::move(blockages);
  }
  const bool is_quick =
      purpose == PlanPurpose::kRoute || purpose == PlanPurpose::kUnblocked;
  planning::PlanBudget budget = is_quick ? first_budget_ : full_budget_;
  if (purpose == PlanPurpose::kUnblocked) budget.improves = false;
  planner_.Start(request, budget);
  asked_ = Asked{.purpose = purpose,
                 .since = now,
                 .has_blockages = !request.blockages.empty()};
}

void PlanRequests::Cancel() {
  if (!asked_.has_value()) return;
  planner_.Cancel();
  asked_.reset();
}

bool PlanRequests::Answer::HasPath() const {
  return result.ok() && result->failure == core::NavigationCause::kNone &&
         !result->path.empty();
}

std::optional<PlanRequests::Answer> PlanRequests::Take() {
  if (!asked_.has_value()) return std::nullopt;
  std::optional<absl::StatusOr<planning::PlanResult>> result = planner_.Take();
  if (!result.has_value()) return std::nullopt;
  const Asked asked = *std::exchange(asked_, std::nullopt);
  return Answer{.purpose = asked.purpose,
                .had_blockages = asked.has_blockages,
                .result = *std::move(result)};
}

std::optional<PlanRequests::Answer> PlanRequests::TakeInTime(
    base::MonotonicTime now) {
  std::optional<Answer> answer = Take();
  if (answer.has_value() || !asked_.has_value() ||
      base::SecondsBetween(asked_->since, now) < max_plan_s_) {
    return answer;
  }
  planning::PlanResult late;
  late.failure = core::NavigationCause::kPlanTimeout;
  late.why = "the planner did not come to an end";
  answer = Answer{.purpose = asked_->purpose,
                  .had_blockages = asked_->has_blockages,
                  .result = std::move(late)};
  Cancel();
  return answer;
}

}  // namespace treeline::behavior

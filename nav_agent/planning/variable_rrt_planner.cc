#include "nav_agent/planning/variable_rrt_planner.h"

#include <optional>
#include <utility>

#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "nav_agent/planning/path_improver.h"

namespace treeline {
namespace {

constexpr uint64_t kSamples = 1;
constexpr uint64_t kImprovements = 2;
// One sample in so many is the other tree's root.
constexpr uint32_t kGoalEvery = 16;
constexpr int kStopEvery = 16;

double SecondsSince(MonotonicTime start) {
  return MillisecondsBetween(start, SteadyClock().Now()) / 1000;
}

// Anywhere in the area of start and goal.
Spot SampleOf(const PlanGround& ground, const PlanTask& task, uint64_t seed,
              uint64_t iteration) {
  Random random(seed ^ (kSamples << 56), iteration);
  if (random.NextBelow(kGoalEvery) == 0) {
    return iteration % 2 == 0 ? task.goal.spot : task.start.spot;
  }
  const std::vector<uint32_t>& cells =
      ground.cells_of_area[static_cast<size_t>(task.area)];
  const size_t number =
      cells[random.NextBelow(static_cast<uint32_t>(cells.size()))];
  const size_t cell = number % ground.index->cells();
  const size_t width = static_cast<size_t>(ground.index->width());
  const double x = static_cast<double>(cell % width) + random.NextUnit();
  const double y = static_cast<double>(cell / width) + random.NextUnit();
  return {.at = ground.index->resolution_m() * Vec2{x, y},
          .level = static_cast<int>(number / ground.index->cells())};
}

}  // namespace

VariableRrtPlanner::VariableRrtPlanner(std::shared_ptr<const PlanGround> ground,
                                       double max_move_m)
    : ground_(std::move(ground)), max_move_m_(max_move_m) {}

absl::StatusOr<PlanResult> VariableRrtPlanner::Plan(
    const PlanRequest& request, const PlanBudget& budget,
    const std::stop_token& stop) const {
  const MonotonicTime begin = SteadyClock().Now();
  TL_RETURN_IF_ERROR(CheckRequest(request));
  PlanResult result;
  const std::optional<PlanTask> task =
      MakeTask(*ground_, request, max_move_m_, result);
  if (!task.has_value()) {
    result.total_s = SecondsSince(begin);
    return result;
  }
  const auto is_over = [&stop, &budget, begin] {
    return stop.stop_requested() || SecondsSince(begin) >= budget.max_time_s;
  };
  RrtResult grown = GrowVariableRrt(
      task->space, {.start = task->start,
                    .goal = task->goal,
                    .seed = request.seed,
                    .max_iterations = budget.max_iterations,
                    .is_over = is_over,
                    .sample = [this, &task, &request](uint64_t iteration) {
                      return SampleOf(*ground_, *task, request.seed, iteration);
                    }});
  if (stop.stop_requested())
    return absl::CancelledError("planning was stopped");
  result.iterations = grown.iterations;
  const Rigid2& map_from_grid = ground_->index->map().grid(0).map_from_grid;
  for (const Vec2& end : grown.edges) {
    result.tree_edges.push_back(map_from_grid * end);
  }
  if (grown.way.empty()) {
    result.failure = NavigationCause::kPlanTimeout;
    result.why = absl::StrFormat("no way was found in %d iterations and %.3f s",
                                 grown.iterations, SecondsSince(begin));
    result.total_s = SecondsSince(begin);
    return result;
  }
  result.first_path_s = SecondsSince(begin);
  PathImprover improver(task->space, task->start.yaw_rad, task->goal.yaw_rad,
                        std::move(grown.way));
  for (; result.iterations < budget.max_iterations; ++result.iterations) {
    if (result.iterations % kStopEvery == 0 && is_over()) break;
    Random random(request.seed ^ (kImprovements << 56),
                  static_cast<uint64_t>(result.iterations));
    improver.Try(random);
  }
  if (stop.stop_requested())
    return absl::CancelledError("planning was stopped");
  WriteWay(*task, improver.way(), result);
  result.total_s = SecondsSince(begin);
  return result;
}

}  // namespace treeline

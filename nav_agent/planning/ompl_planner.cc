#include "nav_agent/planning/ompl_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <functional>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "nav_agent/planning/ompl_variable_rrt.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/plan_clock.h"
#include "nav_agent/planning/planner_parameters.h"
#include "ompl/base/PlannerData.h"
#include "ompl/base/objectives/PathLengthOptimizationObjective.h"
#include "ompl/base/spaces/RealVectorStateSpace.h"
#include "ompl/geometric/PathGeometric.h"
#include "ompl/geometric/planners/informedtrees/BITstar.h"
#include "ompl/geometric/planners/rrt/InformedRRTstar.h"
#include "ompl/geometric/planners/rrt/RRTConnect.h"
#include "ompl/geometric/planners/rrt/RRTstar.h"
#include "ompl/util/Console.h"
#include "ompl/util/RandomNumbers.h"

namespace treeline::planning {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr std::array<const char*, 5> kNames = {"rrt-connect", "rrt-star",
                                               "bit-star", "informed-rrt-star",
                                               "ompl-variable-rrt"};
// The third coordinate is the level; so small that distances are of x and y.
constexpr double kLevelScale = 1e-3;

// Held while OMPL's generator of seeds is used.
ABSL_CONST_INIT absl::Mutex ompl_mutex(absl::kConstInit);

Spot SpotOf(const ob::State* state) {
  const double* values =
      state->as<ob::RealVectorStateSpace::StateType>()->values;
  return {.at = {values[0], values[1]},
          .level = static_cast<int>(std::lround(values[2] / kLevelScale))};
}

void SetState(const Spot& spot, ob::State* state) {
  double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
  values[0] = spot.at.x;
  values[1] = spot.at.y;
  values[2] = kLevelScale * spot.level;
}

// Thrown through OMPL: its planners ask whether they are to end only between
// two steps, and a step may take seconds (BIT* draws samples in an ellipsoid
// that hardly meets a map until it has enough).
struct TimeIsOver {};

class LevelSpace final : public ob::RealVectorStateSpace {
 public:
  // Throws TimeIsOver from what is asked of it when `is_over` says so.
  LevelSpace(const ConfigurationSpace& space, std::function<bool()> is_over)
      : RealVectorStateSpace(3), space_(&space), is_over_(std::move(is_over)) {
    const GroundIndex& ground = space.ground();
    ob::RealVectorBounds bounds(3);
    bounds.setLow(0);
    bounds.setHigh(0, ground.width() * ground.resolution_m());
    bounds.setHigh(1, ground.height() * ground.resolution_m());
    bounds.setLow(2, -0.4 * kLevelScale);
    bounds.setHigh(2, (ground.levels() - 0.6) * kLevelScale);
    setBounds(bounds);
  }
  bool satisfiesBounds(const ob::State* state) const override {
    EndIfOver();
    return RealVectorStateSpace::satisfiesBounds(state);
  }
  double distance(const ob::State* from, const ob::State* to) const override {
    EndIfOver();
    return RealVectorStateSpace::distance(from, to);
  }
  // Over a join the line goes over to the other level.
  void interpolate(const ob::State* from, const ob::State* to, double t,
                   ob::State* state) const override {
    const Spot begin = SpotOf(from);
    const geometry::Vec2 at = begin.at + t * (SpotOf(to).at - begin.at);
    SetState(space_->Follow(begin, at).value_or(Spot{at, begin.level}), state);
  }

 private:
  void EndIfOver() const {
    if (++questions_ % kOmplAskEvery == 0 && is_over_()) throw TimeIsOver();
  }

  const ConfigurationSpace* space_;
  std::function<bool()> is_over_;
  mutable int questions_ = 0;
};

class CanStand final : public ob::StateValidityChecker {
 public:
  CanStand(const ob::SpaceInformationPtr& space,
           const ConfigurationSpace& drive)
      : StateValidityChecker(space), drive_(&drive) {
    specs_.clearanceComputationType =
        ob::StateValidityCheckerSpecs::BOUNDED_APPROXIMATE;
  }
  bool isValid(const ob::State* state) const override {
    return drive_->FitsTurning(SpotOf(state));
  }
  double clearance(const ob::State* state) const override {
    return drive_->RoomAtLeast_m(SpotOf(state));
  }

 private:
  const ConfigurationSpace* drive_;
};

class CanDrive final : public ob::MotionValidator {
 public:
  CanDrive(const ob::SpaceInformationPtr& space,
           const ConfigurationSpace& drive)
      : MotionValidator(space), drive_(&drive) {}
  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    const Spot end = SpotOf(to);
    const std::optional<Spot> driven = drive_->Drive(SpotOf(from), end.at);
    return driven.has_value() && driven->level == end.level && si_->isValid(to);
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last_valid) const override {
    if (checkMotion(from, to)) return true;
    last_valid.second = 0;
    if (last_valid.first != nullptr) si_->copyState(last_valid.first, from);
    return false;
  }

 private:
  const ConfigurationSpace* drive_;
};

ob::PlannerPtr MakePlanner(const std::string& name,
                           const ob::SpaceInformationPtr& space) {
  if (name == "ompl-variable-rrt") {
    return std::make_shared<OmplVariableRrt>(space);
  }
  if (name == "bit-star") return std::make_shared<og::BITstar>(space);
  if (name == "rrt-connect") {
    auto planner = std::make_shared<og::RRTConnect>(space);
    planner->setRange(kOmplRange_m);
    return planner;
  }
  auto planner = name == "rrt-star"
                     ? std::make_shared<og::RRTstar>(space)
                     : std::make_shared<og::InformedRRTstar>(space);
  planner->setRange(kOmplRange_m);
  return planner;
}

// From where the robot stands, straight ahead (`direction` 1) or back (-1), to
// where it can turn right round; empty if it cannot.
Polyline Leave(const ConfigurationSpace& space, const Stand& stand,
               int direction) {
  Polyline way = {stand.spot};
  if (space.FitsTurning(stand.spot)) return way;
  const geometry::Vec2 ahead = {std::cos(stand.yaw_rad),
                                std::sin(stand.yaw_rad)};
  for (int i = 1; i <= kLongLeavingWay; ++i) {
    const std::optional<Spot> spot = space.Drive(
        stand.spot, stand.spot.at + (direction * i * kWayStep_m) * ahead,
        direction < 0);
    if (!spot.has_value()) return {};
    if (!space.FitsTurning(*spot)) continue;
    way.push_back(*spot);
    return way;
  }
  return {};
}

void AddEdges(const ob::Planner& planner, const ob::SpaceInformationPtr& space,
              PlanResult& result) {
  ob::PlannerData data(space);
  planner.getPlannerData(data);
  // OMPL tags the vertices of goals' trees with 2.
  for (const bool is_of_goal : {false, true}) {
    for (unsigned int i = 0; i < data.numVertices(); ++i) {
      if ((data.getVertex(i).getTag() == 2) != is_of_goal) continue;
      std::vector<unsigned int> others;
      data.getEdges(i, others);
      for (const unsigned int other : others) {
        result.tree_edges.push_back(SpotOf(data.getVertex(i).getState()).at);
        result.tree_edges.push_back(
            SpotOf(data.getVertex(other).getState()).at);
      }
    }
    if (!is_of_goal) result.start_tree_points = result.tree_edges.size();
  }
}

struct Search {
  const std::string& name;
  const ConfigurationSpace& drive;
  uint64_t seed = 0;
  PlanBudget budget;
  const std::stop_token& stop;
  base::MonotonicTime begin;
};

// The best way so far, as planners report it: from either end to the other,
// with or without them.
Polyline ReportedWay(const std::vector<const ob::State*>& states,
                     const Spot& from, const Spot& to) {
  Polyline way;
  for (const ob::State* state : states) way.push_back(SpotOf(state));
  if (!way.empty() && geometry::Norm(way.front().at - from.at) >
                          geometry::Norm(way.back().at - from.at)) {
    std::ranges::reverse(way);
  }
  if (way.empty() || !(way.front() == from)) way.insert(way.begin(), from);
  if (!(way.back() == to)) way.push_back(to);
  return way;
}

// Between two places where the robot can turn. Throws what OMPL throws.
Polyline Solve(const Search& search, const Spot& from, const Spot& to,
               PlanResult& result) {
  ompl::msg::noOutputHandler();
  // 0 stands for none.
  ompl::RNG::setSeed(
      1 + static_cast<std::uint_fast32_t>(base::MixBits(search.seed) >> 33));
  const auto lasts = [&search](double share) {
    return search.stop.stop_requested() ||
           SecondsSince(search.begin) >= share * search.budget.max_time_s;
  };
  auto space = std::make_shared<LevelSpace>(
      search.drive, [&lasts] { return lasts(kOmplLimit); });
  auto info = std::make_shared<ob::SpaceInformation>(space);
  info->setStateValidityChecker(std::make_shared<CanStand>(info, search.drive));
  info->setMotionValidator(std::make_shared<CanDrive>(info, search.drive));
  info->setup();
  auto problem = std::make_shared<ob::ProblemDefinition>(info);
  ob::ScopedState<> start(space);
  ob::ScopedState<> goal(space);
  SetState(from, start.get());
  SetState(to, goal.get());
  problem->setStartAndGoalStates(start, goal);
  problem->setOptimizationObjective(
      std::make_shared<ob::PathLengthOptimizationObjective>(info));
  Polyline reported;
  problem->setIntermediateSolutionCallback(
      [&](const ob::Planner*, const std::vector<const ob::State*>& states,
          const ob::Cost) {
        reported = ReportedWay(states, from, to);
        if (result.first_path_s == 0) {
          result.first_path_s = SecondsSince(search.begin);
        }
      });
  const ob::PlannerPtr planner = MakePlanner(search.name, info);
  planner->setProblemDefinition(problem);
  planner->setup();
  int questions = 0;
  try {
    planner->solve(ob::PlannerTerminationCondition([&] {
      return ++questions > search.budget.max_iterations || lasts(kOmplShare);
    }));
    result.iterations = questions;
    AddEdges(*planner, info, result);
  } catch (const TimeIsOver&) {
    result.iterations = questions;
    return reported;
  }
  Polyline way;
  if (!problem->hasExactSolution()) return way;
  if (result.first_path_s == 0) {
    result.first_path_s = SecondsSince(search.begin);
  }
  auto* path = problem->getSolutionPath()->as<og::PathGeometric>();
  for (const ob::State* state : path->getStates()) {
    way.push_back(SpotOf(state));
  }
  return way;
}

}  // namespace

bool IsOmplPlanner(const std::string& name) {
  return std::ranges::find(kNames, name) != kNames.end();
}

OmplPlanner::OmplPlanner(std::shared_ptr<const PlanGround> ground,
                         std::string name, double max_move_m)
    : ground_(std::move(ground)),
      name_(std::move(name)),
      max_move_m_(max_move_m) {}

absl::StatusOr<PlanResult> OmplPlanner::Plan(
    const PlanRequest& request, const PlanBudget& budget,
    const std::stop_token& stop) const {
  const base::MonotonicTime begin = base::SteadyClock().Now();
  TL_RETURN_IF_ERROR(CheckRequest(request));
  PlanResult result;
  const std::optional<PlanTask> task =
      MakeTask(*ground_, request, max_move_m_, result);
  if (!task.has_value()) {
    result.total_s = SecondsSince(begin);
    return result;
  }
  Polyline way = Leave(task->space, task->start, 1);
  Polyline end = Leave(task->space, task->goal, -1);
  if (way.empty() || end.empty()) {
    result.failure = core::NavigationCause::kNoPath;
    result.why = absl::StrCat(
        "the robot cannot turn at the ", way.empty() ? "start" : "goal",
        ", nor anywhere straight ", way.empty() ? "ahead" : "before it",
        "; variable-rrt may find a way");
    result.total_s = SecondsSince(begin);
    return result;
  }
  try {
    const absl::MutexLock lock(&ompl_mutex);
    Polyline middle = Solve({.name = name_,
                             .drive = task->space,
                             .seed = request.seed,
                             .budget = budget,
                             .stop = stop,
                             .begin = begin},
                            way.back(), end.back(), result);
    if (middle.empty()) way.clear();
    if (middle.size() > 1) {
      way.insert(way.end(), middle.begin() + 1, middle.end());
      way.insert(way.end(), end.rbegin() + 1, end.rend());
    }
  } catch (const std::exception& error) {
    return absl::InternalError(absl::StrCat("OMPL: ", error.what()));
  }
  if (stop.stop_requested())
    return absl::CancelledError("planning was stopped");
  const geometry::Rigid2& map_from_grid =
      ground_->index->map().grid(0).map_from_grid;
  for (geometry::Vec2& point : result.tree_edges) point = map_from_grid * point;
  if (way.empty() ||
      !CanBeDriven(task->space, task->start.yaw_rad, task->goal.yaw_rad, way)) {
    result.failure = core::NavigationCause::kPlanTimeout;
    result.why = absl::StrFormat("%s found no way in %.3f s", name_,
                                 SecondsSince(begin));
    result.first_path_s = 0;
    result.total_s = SecondsSince(begin);
    return result;
  }
  PathSmoother improver(task->space, task->start.yaw_rad, task->goal.yaw_rad,
                        std::move(way));
  for (int idle = 0, i = 0; idle < kIdleAttempts && i < budget.max_iterations;
       ++i) {
    if (i % kStopEvery == 0 &&
        (stop.stop_requested() || SecondsSince(begin) >= budget.max_time_s)) {
      break;
    }
    base::Random random(request.seed, static_cast<uint64_t>(i));
    idle = improver.Try(random) ? 0 : idle + 1;
  }
  WriteWay(*task, improver.way(), result);
  result.total_s = SecondsSince(begin);
  return result;
}

}  // namespace treeline::planning

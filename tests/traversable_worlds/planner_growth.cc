// How planning grows with the map: first paths, paths found in 100 ms and their
// lengths, on generated maps of 256 to 1024 cells a side.
//
//   planner_growth [PAIRS [PLANNER,... [SIZE,... [KIND,... [BEST_SECONDS
//                  [SEED]]]]]]
//
// A KIND may be a file: a map of map_server (.yaml), or one of the moving-AI
// benchmarks (.map, its cells taken as 0.05 m); sizes do not matter to those.
// One line a planner, kind and size, tab-separated; all times are of the
// processor, but those of OMPL's planners by the clock. Found is what has a
// path in 100 ms; a pair of poses counts as one with a way if any plan finds
// one. Lengths are those after 100 ms, against the best known (BestKnown, with
// BEST_SECONDS for each of its plans; 0: none); best_over_bound is how far that
// may be from the truth.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/processor_time.h"
#include "nav_agent/planning/global_planner.h"
#include "nav_agent/planning/plan_frame.h"
#include "tests/traversable_worlds/best_known.h"
#include "tests/traversable_worlds/planner_maps.h"

namespace treeline {
namespace {

// Of maps and pairs: not among the seeds that suites are judged by.
constexpr uint64_t kSeed = 4000;
constexpr int kPairsAMap = 5;
// Ways longer by so many percent are worth looking at.
constexpr double kMuchLonger = 1;
// Long plans that the best known way is chosen of.
constexpr int kBestRounds = 3;

struct Options {
  int pairs = 20;
  std::vector<std::string> planners;
  // Of processor time for each long plan (s); 0: none.
  double best_s = 1;
  uint64_t seed = kSeed;
};

using Map = std::shared_ptr<const traversability::NavigationMap>;

using Planner = std::unique_ptr<planning::GlobalPlanner>;

Planner PlannerOf(const Map& map, const std::string& name) {
  planning::GlobalPlannerOptions options;
  options.planner = name;
  auto made = planning::MakeGlobalPlanner(map, core::RobotModel(), options);
  if (!made.ok()) std::abort();
  return *std::move(made);
}

// Of OMPL's planners time is by the clock.
planning::PlanResult PlanOf(const Planner& planner,
                            const planning::PlanRequest& request,
                            double time_s) {
  const base::ThreadProcessorClock clock;
  auto result = planner->Plan(request,
                              {.max_iterations = 1'000'000'000,
                               .max_time_s = time_s,
                               .improves = true,
                               .clock = &clock},
                              {});
  if (!result.ok()) std::abort();
  return *std::move(result);
}

// The processor time of the first path, from request to result (ms); infinite
// if there is none. Planners of OMPL go on when they have one: theirs is by the
// clock.
double FirstPath_ms(const std::string& name, const Planner& planner,
                    const planning::PlanRequest& request) {
  const bool is_own = name == "variable-rrt";
  const base::ThreadProcessorClock clock;
  const double before_ms = base::ThreadProcessorTime_ms();
  const auto result = planner->Plan(request,
                                    {.max_iterations = 1'000'000'000,
                                     .max_time_s = is_own ? 10 : 0.1,
                                     .improves = false,
                                     .clock = &clock},
                                    {});
  const double took_ms = base::ThreadProcessorTime_ms() - before_ms;
  if (!result.ok() || result->failure != core::NavigationCause::kNone) {
    if (is_own && result.ok()) {
      std::fprintf(stderr, "%s after %.0f ms of processor time\n",
                   core::NavigationCauseName(result->failure), took_ms);
    }
    return std::numeric_limits<double>::infinity();
  }
  return is_own ? took_ms : 1e3 * result->first_path_s;
}

struct Tally {
  int with_way = 0;
  int found = 0;
  int said_none = 0;
  std::vector<double> first_ms;
  std::vector<double> total_ms;
  std::vector<double> excess;
  std::vector<double> slack;
  std::vector<double> comfort;
  std::vector<double> bound;
  int other_sides = 0;
};

void Count(const planning::PlanResult& result, const BestKnown* best,
           double first_ms, Tally& tally) {
  tally.total_ms.push_back(1e3 * result.total_s);
  const bool is_found = result.failure == core::NavigationCause::kNone;
  const bool is_known = best != nullptr && std::isfinite(best->length_m());
  if (!is_known && !is_found && !std::isfinite(first_ms)) return;
  ++tally.with_way;
  tally.first_ms.push_back(first_ms);
  tally.found += first_ms <= 100 ? 1 : 0;
  if (!is_found) {
    tally.said_none += result.failure == core::NavigationCause::kNoPath ? 1 : 0;
    return;
  }
  if (!is_known) return;
  const ExcessOf excess = best->Excess(result);
  tally.excess.push_back(excess.total);
  tally.slack.push_back(excess.slack);
  tally.comfort.push_back(excess.comfort);
  tally.other_sides += excess.is_other_side ? 1 : 0;
  if (best->bound_m() > 0) {
    tally.bound.push_back(100 * (best->length_m() / best->bound_m() - 1));
  }
}

void Tell(const std::string& name, const planning::PlanRequest& request,
          const planning::PlanResult& result, const BestKnown* best) {
  const bool is_found = result.failure == core::NavigationCause::kNone;
  const ExcessOf excess = best == nullptr ? ExcessOf{} : best->Excess(result);
  if (is_found && excess.total < kMuchLonger) return;
  const geometry::Rigid2& from = request.start.map_from_base;
  const geometry::Rigid2& to = request.goal.map_from_base;
  std::fprintf(stderr,
               "%s seed %d: (%.3f, %.3f, %.3f) to (%.3f, %.3f, %.3f), best "
               "%.2f m, bound %.2f m, here %.2f m: %s %s; %.2f %% longer: "
               "other sides %.2f%s, comfort %.2f, slack %.2f (%.0f ms)\n",
               name.c_str(), static_cast<int>(request.seed), from.translation.x,
               from.translation.y, from.yaw_rad, to.translation.x,
               to.translation.y, to.yaw_rad,
               best == nullptr ? 0 : best->length_m(),
               best == nullptr ? 0 : best->bound_m(), result.length_m,
               core::NavigationCauseName(result.failure), result.why.c_str(),
               excess.total, excess.other_side,
               excess.is_other_side ? "" : " (the same)", excess.comfort,
               excess.slack, 1e3 * result.total_s);
}

void MeasureOn(const Map& map, const std::string& name, int pairs,
               uint64_t seed, const Options& options,
               std::vector<Tally>& tallies) {
  std::vector<Planner> measured;
  for (const std::string& planner : options.planners) {
    measured.push_back(PlannerOf(map, planner));
  }
  const planning::PlanGround ground(map, core::RobotModel(),
                                    planning::GlobalPlannerOptions().margin_m);
  const PointWay point(ground);
  const Planner own = PlannerOf(map, "variable-rrt");
  for (const planning::PlanRequest& request : RequestsOn(map, pairs, seed)) {
    std::unique_ptr<BestKnown> best;
    if (options.best_s > 0) {
      best = std::make_unique<BestKnown>(ground, point, *own, request,
                                         kBestRounds, options.best_s);
    }
    for (size_t i = 0; i < measured.size(); ++i) {
      const planning::PlanResult result = PlanOf(measured[i], request, 0.1);
      Count(result, best.get(),
            FirstPath_ms(options.planners[i], measured[i], request),
            tallies[i]);
      Tell(absl::StrCat(options.planners[i], " ", name), request, result,
           best.get());
    }
  }
}

void Print(const std::string& planner, const std::string& kind,
           const std::string& size, const Tally& tally) {
  std::printf(
      "%s\t%s\t%s\t%d\t%d\t%d\t%.2f\t%.2f\t%.2f\t%.2f\t%.2f\t%d\t%.2f\t%.2f"
      "\t%.2f\t%.2f\t%.2f\t%.2f\t%.0f\n",
      planner.c_str(), kind.c_str(), size.c_str(), tally.found, tally.with_way,
      tally.said_none, Share(tally.first_ms, 0.5), Share(tally.first_ms, 0.99),
      Share(tally.excess, 0.5), Share(tally.excess, 0.9),
      Share(tally.excess, 1), tally.other_sides, Share(tally.comfort, 0.5),
      Share(tally.comfort, 1), Share(tally.slack, 0.5), Share(tally.slack, 1),
      Share(tally.bound, 0.5), Share(tally.bound, 1), Share(tally.total_ms, 1));
  std::fflush(stdout);
}

void Measure(const std::string& kind, const std::string& size,
             const Options& options) {
  std::vector<Tally> tallies(options.planners.size());
  const bool is_file = IsMapFile(kind);
  const int pairs_a_map = is_file ? options.pairs : kPairsAMap;
  for (int done = 0; done < options.pairs; done += pairs_a_map) {
    const uint64_t seed = options.seed + static_cast<uint64_t>(done);
    const Map map = is_file
                        ? ReadPlannerMap(kind)
                        : MakePlannerMap(kind, std::atoi(size.c_str()), seed);
    MeasureOn(map, absl::StrCat(kind, " ", size),
              std::min(pairs_a_map, options.pairs - done), seed, options,
              tallies);
  }
  for (size_t i = 0; i < options.planners.size(); ++i) {
    Print(options.planners[i], kind, size, tallies[i]);
  }
}

int Main(const std::vector<std::string>& arguments) {
  const auto list = [&arguments](size_t at, const char* otherwise) {
    const std::string text = arguments.size() > at ? arguments[at] : otherwise;
    return std::vector<std::string>(absl::StrSplit(text, ','));
  };
  Options options;
  options.planners = list(2, "variable-rrt,bit-star");
  if (!absl::SimpleAtoi(list(1, "20")[0], &options.pairs) ||
      !absl::SimpleAtod(list(5, "1")[0], &options.best_s) ||
      !absl::SimpleAtoi(list(6, "4000")[0], &options.seed) ||
      options.pairs < 1) {
    std::fprintf(stderr,
                 "planner_growth [PAIRS [PLANNER,... [SIZE,... [KIND,... "
                 "[BEST_SECONDS [SEED]]]]]]\n");
    return 2;
  }
  std::printf(
      "planner\tkind\tsize\tfound\tof\tsaid_none\tfirst_p50_ms\tfirst_p99_ms\t"
      "longer_p50_%%\tlonger_p90_%%\tlonger_max_%%\tother_sides\t"
      "comfort_p50_%%\tcomfort_max_%%\tslack_p50_%%\tslack_max_%%\t"
      "best_over_bound_p50_%%\tbest_over_bound_max_%%\ttotal_max_ms\n");
  for (const std::string& kind : list(4, "city,maze,rooms,caves,cylinders")) {
    for (const std::string& size : list(3, "256,512,768,1024")) {
      Measure(kind, size, options);
      if (IsMapFile(kind)) break;
    }
  }
  return 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  return treeline::Main(std::vector<std::string>(argv, argv + argc));
}

// How planning grows with the map: first paths, paths found in 100 ms and their
// lengths, on generated maps of 256 to 1024 cells a side.
//
//   planner_growth [PAIRS [PLANNER,... [SIZE,... [KIND,... [BEST_SECONDS]]]]]
//
// One line a planner, kind and size, tab-separated; first paths in processor
// time, and found is what has one in 100 ms of it. Lengths are those after 100
// ms by the clock. A pair of poses counts as
// one with a way if any planner finds one in BEST_SECONDS; what is found in
// that time is the length that others are compared with.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "common/base/processor_time.h"
#include "nav_agent/planning/global_planner.h"
#include "tests/traversable_worlds/planner_maps.h"

namespace treeline {
namespace {

// Of maps and pairs: not among the seeds that suites are judged by.
constexpr uint64_t kSeed = 4000;
constexpr int kPairsAMap = 5;
// Such ways are worth looking at.
constexpr double kMuchLonger = 1.05;

using Map = std::shared_ptr<const traversability::NavigationMap>;

using Planner = std::unique_ptr<planning::GlobalPlanner>;

Planner PlannerOf(const Map& map, const std::string& name) {
  planning::GlobalPlannerOptions options;
  options.planner = name;
  auto made = planning::MakeGlobalPlanner(map, core::RobotModel(), options);
  if (!made.ok()) std::abort();
  return *std::move(made);
}

planning::PlanResult PlanOf(const Planner& planner,
                            const planning::PlanRequest& request,
                            double time_s) {
  auto result = planner->Plan(
      request, {.max_iterations = 1'000'000'000, .max_time_s = time_s}, {});
  if (!result.ok()) std::abort();
  return *std::move(result);
}

// The shortest way that is found with much time; infinite if none is.
double BestLength_m(const std::vector<Planner>& planners,
                    planning::PlanRequest request, double time_s) {
  double best_m = std::numeric_limits<double>::infinity();
  if (!(time_s > 0)) return best_m;
  for (const Planner& planner : planners) {
    request.seed += 7919;
    const planning::PlanResult result = PlanOf(planner, request, time_s);
    if (result.failure == core::NavigationCause::kNone) {
      best_m = std::min(best_m, result.length_m);
    }
  }
  return best_m;
}

// The processor time of the first path, from request to result (ms); infinite
// if there is none. Planners of OMPL go on when they have one: theirs is by the
// clock.
double FirstPath_ms(const std::string& name, const Planner& planner,
                    const planning::PlanRequest& request) {
  const bool is_own = name == "variable-rrt";
  const double before_ms = base::ThreadProcessorTime_ms();
  const auto result = planner->Plan(request,
                                    {.max_iterations = 1'000'000'000,
                                     .max_time_s = is_own ? 10 : 0.1,
                                     .improves = false},
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
};

void Count(const planning::PlanResult& result, double best_m, double first_ms,
           Tally& tally) {
  tally.total_ms.push_back(1e3 * result.total_s);
  const bool is_found = result.failure == core::NavigationCause::kNone;
  if (!std::isfinite(best_m) && !is_found && !std::isfinite(first_ms)) return;
  ++tally.with_way;
  tally.first_ms.push_back(first_ms);
  tally.found += first_ms <= 100 ? 1 : 0;
  if (!is_found) {
    tally.said_none += result.failure == core::NavigationCause::kNoPath ? 1 : 0;
    return;
  }
  if (std::isfinite(best_m)) {
    tally.excess.push_back(std::max(0.0, 100 * (result.length_m / best_m - 1)));
  }
}

void Measure(const std::string& kind, int size, int pairs,
             const std::vector<std::string>& planners, double best_s) {
  std::vector<Tally> tallies(planners.size());
  for (int done = 0; done < pairs; done += kPairsAMap) {
    const uint64_t seed = kSeed + static_cast<uint64_t>(done);
    const Map map = MakePlannerMap(kind, size, seed);
    std::vector<Planner> measured;
    for (const std::string& name : planners) {
      measured.push_back(PlannerOf(map, name));
    }
    std::vector<Planner> best;
    for (const char* name : {"variable-rrt", "variable-rrt", "bit-star"}) {
      best.push_back(PlannerOf(map, name));
    }
    for (const planning::PlanRequest& request :
         RequestsOn(map, std::min(kPairsAMap, pairs - done), seed)) {
      const double best_m = BestLength_m(best, request, best_s);
      for (size_t i = 0; i < planners.size(); ++i) {
        const planning::PlanResult result = PlanOf(measured[i], request, 0.1);
        Count(result, best_m, FirstPath_ms(planners[i], measured[i], request),
              tallies[i]);
        if (result.failure != core::NavigationCause::kNone ||
            result.length_m > kMuchLonger * best_m) {
          const geometry::Rigid2& from = request.start.map_from_base;
          const geometry::Rigid2& to = request.goal.map_from_base;
          std::fprintf(stderr,
                       "%s %s %d seed %d: (%.3f, %.3f, %.3f) to (%.3f, %.3f, "
                       "%.3f), best %.2f m, here %.2f m: %s: %s (%.0f ms)\n",
                       planners[i].c_str(), kind.c_str(), size,
                       static_cast<int>(seed), from.translation.x,
                       from.translation.y, from.yaw_rad, to.translation.x,
                       to.translation.y, to.yaw_rad, best_m, result.length_m,
                       core::NavigationCauseName(result.failure),
                       result.why.c_str(), 1e3 * result.total_s);
        }
      }
    }
  }
  for (size_t i = 0; i < planners.size(); ++i) {
    const Tally& tally = tallies[i];
    std::printf("%s\t%s\t%d\t%d\t%d\t%d\t%.2f\t%.2f\t%.2f\t%.2f\t%.2f\t%.0f\n",
                planners[i].c_str(), kind.c_str(), size, tally.found,
                tally.with_way, tally.said_none, Share(tally.first_ms, 0.5),
                Share(tally.first_ms, 0.99), Share(tally.excess, 0.5),
                Share(tally.excess, 0.9), Share(tally.excess, 1),
                Share(tally.total_ms, 1));
    std::fflush(stdout);
  }
}

int Main(const std::vector<std::string>& arguments) {
  const auto list = [&arguments](size_t at, const char* otherwise) {
    const std::string text = arguments.size() > at ? arguments[at] : otherwise;
    return std::vector<std::string>(absl::StrSplit(text, ','));
  };
  const int pairs = std::atoi(list(1, "20")[0].c_str());
  const std::vector<std::string> planners = list(2, "variable-rrt,bit-star");
  const std::vector<std::string> sizes = list(3, "256,512,768,1024");
  const std::vector<std::string> kinds =
      list(4, "city,maze,rooms,caves,cylinders");
  double best_s = 0;
  if (!absl::SimpleAtod(list(5, "1")[0], &best_s) || pairs < 1) return 2;
  std::printf(
      "planner\tkind\tsize\tfound\tof\tsaid_none\tfirst_p50_ms\tfirst_p99_ms\t"
      "longer_p50_%%\tlonger_p90_%%\tlonger_max_%%\ttotal_max_ms\n");
  for (const std::string& kind : kinds) {
    for (const std::string& size : sizes) {
      Measure(kind, std::atoi(size.c_str()), pairs, planners, best_s);
    }
  }
  return 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  return treeline::Main(std::vector<std::string>(argv, argv + argc));
}

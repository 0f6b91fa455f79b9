#include "evaluation/missions/mission_report.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "evaluation/suites/suite_report.h"

namespace treeline::missions {
namespace {

struct Tally {
  int runs = 0;
  int good = 0;
  int arrived = 0;
  int collisions_of_robot = 0;
  int collisions = 0;
  int stairs = 0;
  int edges = 0;
  int false_losses = 0;
  double driven_m = 0;
  double simulated_s = 0;
  double way_m = 0;
  double goal_error_m = 0;
  suites::StepTimes times;

  void Add(const MissionRun& run) {
    ++runs;
    good += run.IsGood() ? 1 : 0;
    arrived += run.outcome == MissionOutcome::kArrived ? 1 : 0;
    collisions_of_robot += run.collisions_of_robot;
    collisions += run.collisions;
    stairs += run.stair_entries;
    edges += run.edge_entries;
    false_losses += run.false_losses;
    driven_m += run.driven_m;
    simulated_s += run.simulated_s;
    way_m += run.mission.route.way_m;
    if (run.outcome == MissionOutcome::kArrived) {
      goal_error_m = std::max(goal_error_m, run.goal_error.distance_m);
    }
    times.Add(run.times);
  }
};

std::string Row(const std::string& name, const Tally& tally) {
  return absl::StrFormat(
      "%-14s %5d %8d %6.1f %% %6d /%4d %6d %6d %7.0f %8.0f %6.2f\n", name,
      tally.runs, tally.good,
      tally.runs > 0 ? 100.0 * tally.good / tally.runs : 0.0,
      tally.collisions_of_robot, tally.collisions, tally.stairs, tally.edges,
      tally.driven_m, tally.simulated_s,
      tally.way_m > 0 ? tally.driven_m / tally.way_m : 0.0);
}

std::string RunJson(const MissionRun& run) {
  std::string json =
      suites::RunHeadJson(run, {"scene", base::JsonQuoted(run.scene)},
                          MissionOutcomeName(run.outcome), run.IsGood());
  absl::StrAppendFormat(
      &json,
      "     \"start\": %s, \"goal\": %s, \"shortest_way_m\": %.3f, "
      "\"surprise\": %s, \"passers\": %d,\n",
      suites::PlacementJson(run.mission.route.start),
      suites::PlacementJson(run.mission.route.goal), run.mission.route.way_m,
      base::JsonQuoted(run.surprise), run.mission.passers);
  absl::StrAppendFormat(&json,
                        "     %s, \"replans\": %d, \"recoveries\": %d, "
                        "\"false_losses\": %d,\n",
                        suites::DriveJson(run), run.replans, run.recoveries,
                        run.false_losses);
  absl::StrAppendFormat(
      &json,
      "     \"goal_error\": %s, \"estimate_error\": %s,\n     \"steps\": %s}",
      suites::PoseMissJson(run.goal_error),
      suites::PoseMissJson(run.estimate_error),
      suites::StepTimesJson(run.times));
  return json;
}

}  // namespace

std::string MissionSummary(const std::vector<MissionRun>& runs, int expected) {
  std::string text =
      "                               good  collisions            edges  "
      "driven     time driven/\n"
      "world           runs     good  share   robot / all stairs (falls)     "
      "(m)      (s) shortest\n";
  Tally all;
  suites::Tallies<Tally> tallies;
  for (const MissionRun& run : runs) {
    all.Add(run);
    tallies.Add(
        run.scene.empty() ? run.world : absl::StrCat("scene ", run.scene), run);
  }
  for (const auto& [name, tally] : tallies.rows()) text += Row(name, tally);
  text += Row("all", all);
  absl::StrAppendFormat(
      &text,
      "Furthest from a goal at which it said that it had arrived: %.2f m. "
      "Declared itself lost, and was not: %d times.\n"
      "A step of the navigator took up to %.2f ms (p99), %.1f ms at worst; %d "
      "of %d took longer than 25 ms.\n"
      "%d plans beside them: %.1f ms each, %.1f ms at worst; %d would have "
      "been later than %d steps.\n",
      all.goal_error_m, all.false_losses, all.times.Percentile_ms(0.99),
      all.times.highest_ms, all.times.missed, all.times.steps,
      all.times.plans.plans,
      all.times.plans.total_ms / std::max(1, all.times.plans.plans),
      all.times.plans.longest_ms, all.times.plans.late,
      suites::kSuitePlanSteps);
  text += suites::NotRunText(runs.size(), expected, "missions");
  for (const MissionRun& run : runs) {
    if (run.IsGood()) continue;
    absl::StrAppendFormat(
        &text, "  %s%s seed %d: %s (%s) after %.0f s%s%s%s\n", run.world,
        run.scene.empty() ? "" : absl::StrCat(", scene ", run.scene), run.seed,
        MissionOutcomeName(run.outcome), core::NavigationCauseName(run.cause),
        run.simulated_s, run.why.empty() ? "" : ": ", run.why,
        suites::CollisionsText(run));
  }
  return text;
}

std::string MissionJson(const std::vector<MissionRun>& runs, int expected,
                        bool people, const worlds::Rearrangement& rearranged) {
  Tally all;
  for (const MissionRun& run : runs) all.Add(run);
  std::string json = absl::StrFormat(
      "{\n  \"suite\": \"missions\",\n  \"people\": %s,\n"
      "  \"rearranged\": {\"seed\": %d, \"share\": %g},\n  \"expected\": %d,\n"
      "  \"runs\": %d,\n  \"good\": %d,\n  \"arrived\": %d,\n"
      "  \"collisions\": %d,\n  \"collisions_by_robot\": %d,\n"
      "  \"stair_entries\": %d,\n  \"edge_entries\": %d,\n"
      "  \"missed_deadlines\": %d,\n  \"missions\": ",
      people ? "true" : "false", rearranged.seed, rearranged.share, expected,
      all.runs, all.good, all.arrived, all.collisions, all.collisions_of_robot,
      all.stairs, all.edges, all.times.missed);
  return json + suites::RunsJson(runs, RunJson) + "\n}\n";
}

}  // namespace treeline::missions

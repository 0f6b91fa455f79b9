#include "evaluation/fields/field_report.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "evaluation/suites/suite_report.h"
#include "simulation/worlds/world.h"

namespace treeline::fields {
namespace {

int Count(const std::vector<FieldRun>& runs, FieldOutcome outcome) {
  return static_cast<int>(
      std::ranges::count(runs, outcome, &FieldRun::outcome));
}

// Of the runs that reached the goal; 0: none did.
double MeanTime_s(const std::vector<FieldRun>& runs) {
  double sum_s = 0;
  for (const FieldRun& run : runs) sum_s += run.IsGood() ? run.time_s : 0;
  const int good = Count(runs, FieldOutcome::kReached);
  return good > 0 ? sum_s / good : 0;
}

std::string RunJson(const FieldRun& run) {
  std::string json = suites::RunHeadJson(
      run, {"best_way_m", absl::StrFormat("%.3f", run.best_way.length_m)},
      FieldOutcomeName(run.outcome), run.IsGood());
  absl::StrAppendFormat(&json,
                        "     \"best_way_of\": \"%s\", \"score\": %.4f, "
                        "\"time_s\": %.3f, \"way_changes\": %d, "
                        "\"recoveries\": %d,\n     ",
                        BestWaySourceName(run.best_way.source), run.Score(),
                        run.time_s, run.way_changes, run.recoveries);
  absl::StrAppend(&json, suites::DriveJson(run),
                  ",\n     \"steps\": ", suites::StepTimesJson(run.times), "}");
  return json;
}

}  // namespace

double MeanScore(const std::vector<FieldRun>& runs) {
  double sum = 0;
  for (const FieldRun& run : runs) sum += run.Score();
  return runs.empty() ? 0 : sum / static_cast<double>(runs.size());
}

std::string FieldSummary(const std::vector<FieldRun>& runs, int expected) {
  suites::StepTimes times;
  std::string text;
  int straight = 0;
  for (const FieldRun& run : runs) {
    times.Add(run.times);
    if (worlds::IsGazeboWorld(run.world) &&
        run.best_way.source == BestWaySource::kStraightLine) {
      ++straight;
    }
    if (run.IsGood()) continue;
    absl::StrAppendFormat(&text,
                          "  %s, seed %d: %s after %.1f s, %.1f m from "
                          "the goal; %s\n",
                          run.world, run.seed, FieldOutcomeName(run.outcome),
                          run.time_s, run.goal_off_m, run.why);
  }
  if (straight > 0) {
    absl::StrAppendFormat(
        &text,
        "No path file (path_files/path_N.npy) lies beside %d of the fields: "
        "their best way is taken as straight, which scores lower\n",
        straight);
  }
  return absl::StrFormat(
      "%d of %d fields reached, %d touched, %d struck, %d timeouts, %d failed; "
      "mean score %.4f of 0.5; mean time %.1f s\n"
      "%sSteps: %.2f ms on average, p99 below %.2f ms, at most %.1f ms\n"
      "%s",
      Count(runs, FieldOutcome::kReached), runs.size(),
      Count(runs, FieldOutcome::kTouched), Count(runs, FieldOutcome::kStruck),
      Count(runs, FieldOutcome::kTimeout), Count(runs, FieldOutcome::kFailed),
      MeanScore(runs), MeanTime_s(runs),
      suites::NotRunText(runs.size(), expected, "fields"),
      times.steps > 0 ? times.total_ms / static_cast<double>(times.steps) : 0,
      times.Percentile_ms(0.99), times.highest_ms, text);
}

std::string FieldJson(const std::vector<FieldRun>& runs, int expected,
                      const std::string& robot) {
  return absl::StrFormat(
      "{\n  \"suite\": \"barn\",\n  \"robot\": %s,\n  \"expected\": %d,\n"
      "  \"runs_done\": %d,\n  \"reached\": %d,\n  \"touched\": %d,\n"
      "  \"struck\": %d,\n  \"timeouts\": %d,\n  \"failed\": %d,\n"
      "  \"mean_score\": %.4f,\n"
      "  \"mean_time_s\": %.3f,\n  \"runs\": %s\n}\n",
      base::JsonQuoted(robot), expected, runs.size(),
      Count(runs, FieldOutcome::kReached), Count(runs, FieldOutcome::kTouched),
      Count(runs, FieldOutcome::kStruck), Count(runs, FieldOutcome::kTimeout),
      Count(runs, FieldOutcome::kFailed), MeanScore(runs), MeanTime_s(runs),
      suites::RunsJson(runs, RunJson));
}

}  // namespace treeline::fields

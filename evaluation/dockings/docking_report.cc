#include "evaluation/dockings/docking_report.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "evaluation/suites/suite_report.h"

namespace treeline::dockings {
namespace {

double InDegrees(double rad) { return rad * 180 / std::numbers::pi; }

struct Tally {
  int runs = 0;
  int good = 0;
  int tries = 0;
  int collisions = 0;
  int losses = 0;
  // Of those that say that they are docked.
  std::vector<double> off_m = {};
  std::vector<double> turned_rad = {};
  std::vector<double> estimate_m = {};

  void Add(const DockingRun& run) {
    ++runs;
    good += run.IsGood() ? 1 : 0;
    tries += run.failed_tries;
    collisions += run.collisions_of_robot;
    losses += run.false_losses;
    if (run.outcome == DockingSuiteOutcome::kFailed ||
        run.outcome == DockingSuiteOutcome::kTimeout) {
      return;
    }
    off_m.push_back(std::hypot(run.miss.along_m, run.miss.aside_m));
    turned_rad.push_back(std::abs(run.miss.turned_rad));
    estimate_m.push_back(run.estimate_off_m);
  }
};

std::string Row(const std::string& name, const Tally& tally) {
  return absl::StrFormat(
      "%-22s %4d %5d  %5.1f %5.1f %5.1f  %5.2f %5.2f  %5.1f %5.1f %5d %5d "
      "%5d\n",
      name, tally.runs, tally.good,
      100 * suites::NearestQuantile(tally.off_m, 0.5),
      100 * suites::NearestQuantile(tally.off_m, 0.95),
      100 * suites::NearestQuantile(tally.off_m, 1),
      InDegrees(suites::NearestQuantile(tally.turned_rad, 0.5)),
      InDegrees(suites::NearestQuantile(tally.turned_rad, 1)),
      100 * suites::NearestQuantile(tally.estimate_m, 0.5),
      100 * suites::NearestQuantile(tally.estimate_m, 1), tally.tries,
      tally.collisions, tally.losses);
}

std::string RunJson(const DockingRun& run) {
  std::string json =
      suites::RunHeadJson(run, {"scene", base::JsonQuoted(run.scene)},
                          DockingSuiteOutcomeName(run.outcome), run.IsGood());
  absl::StrAppendFormat(
      &json,
      "     \"dock\": %s, \"start\": %s, \"failed_tries\": %d, "
      "\"docking_s\": %.1f, \"losses\": %d, "
      "\"believed_s\": %.1f,\n"
      "     \"along_m\": %.4f, \"aside_m\": %.4f, \"turned_rad\": %.4f, "
      "\"estimate_off_m\": %.4f,\n     %s}",
      suites::PlacementJson(run.dock), suites::PlacementJson(run.start),
      run.failed_tries, run.docking_s, run.false_losses, run.believed_s,
      run.miss.along_m, run.miss.aside_m, run.miss.turned_rad,
      run.estimate_off_m, suites::DriveJson(run));
  return json;
}

}  // namespace

std::string DockingSummary(const std::vector<DockingRun>& runs, int expected) {
  std::string text =
      "                                  off in truth (cm)  turned (deg)  AMCL "
      "(cm)  tries ran\n"
      "world, scene           runs  good    50%   95%  most    50%  most    "
      "50%  most in vain into lost\n";
  Tally all;
  suites::Tallies<Tally> tallies;
  for (const DockingRun& run : runs) {
    all.Add(run);
    tallies.Add(absl::StrCat(run.world, ", ", run.scene), run);
  }
  for (const auto& [name, tally] : tallies.rows()) text += Row(name, tally);
  text += Row("all", all);
  text += suites::NotRunText(runs.size(), expected, "dockings");
  for (const DockingRun& run : runs) {
    if (run.IsGood()) continue;
    absl::StrAppendFormat(
        &text,
        "  %s, %s, seed %d: %s (%.1f cm along, %.1f aside, %.1f degrees), %d "
        "tries in vain%s%s%s\n",
        run.world, run.scene, run.seed, DockingSuiteOutcomeName(run.outcome),
        100 * run.miss.along_m, 100 * run.miss.aside_m,
        InDegrees(run.miss.turned_rad), run.failed_tries,
        run.why.empty() ? "" : ": ", run.why, suites::CollisionsText(run));
  }
  return text;
}

std::string DockingJson(const std::vector<DockingRun>& runs, int expected) {
  Tally all;
  for (const DockingRun& run : runs) all.Add(run);
  std::string json = absl::StrFormat(
      "{\n  \"suite\": \"docking\",\n  \"expected\": %d,\n"
      "  \"runs\": %d,\n  \"good\": %d,\n  \"off_p95_m\": %.4f,\n"
      "  \"off_most_m\": %.4f,\n  \"dockings\": ",
      expected, all.runs, all.good, suites::NearestQuantile(all.off_m, 0.95),
      suites::NearestQuantile(all.off_m, 1));
  return json + suites::RunsJson(runs, RunJson) + "\n}\n";
}

}  // namespace treeline::dockings

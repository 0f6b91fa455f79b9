#include "evaluation/kidnaps/kidnap_report.h"

#include <algorithm>
#include <array>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "evaluation/suites/suite_report.h"

namespace treeline::kidnaps {
namespace {

constexpr std::array kOutcomes = {
    KidnapOutcome::kBack,      KidnapOutcome::kLate,
    KidnapOutcome::kWrong,     KidnapOutcome::kNeedHelp,
    KidnapOutcome::kUnnoticed, KidnapOutcome::kSearching,
    KidnapOutcome::kFell};

struct Tally {
  int runs = 0;
  std::array<int, kOutcomes.size()> outcomes{};
  int wrong_resumptions = 0;
  int arrived = 0;
  int collisions_of_robot = 0;
  int stairs = 0;
  int edges = 0;
  std::vector<double> back_s;
  std::vector<double> noticed_s;
  suites::StepTimes times;

  void Add(const KidnapRun& run) {
    ++runs;
    ++outcomes[static_cast<size_t>(run.outcome)];
    wrong_resumptions += run.wrong_resumptions;
    arrived += run.arrived ? 1 : 0;
    collisions_of_robot += run.collisions_of_robot;
    stairs += run.stair_entries;
    edges += run.edge_entries;
    if (run.back_after_s >= 0) back_s.push_back(run.back_after_s);
    if (run.noticed_after_s >= 0) noticed_s.push_back(run.noticed_after_s);
    times.Add(run.times);
  }
};

std::string Row(const std::string& name, const Tally& tally) {
  std::string row = absl::StrFormat("%-14s %5d", name, tally.runs);
  for (const int count : tally.outcomes)
    absl::StrAppendFormat(&row, "%6d", count);
  absl::StrAppendFormat(
      &row, " %6.1f %% %6d %6d %6.1f %6.1f %5d\n",
      tally.runs > 0 ? 100.0 * tally.outcomes[0] / tally.runs : 0.0,
      tally.wrong_resumptions, tally.arrived,
      suites::NearestQuantile(tally.back_s, 0.5),
      suites::NearestQuantile(tally.back_s, 0.95), tally.collisions_of_robot);
  return row;
}

suites::Tallies<Tally> TalliesOf(const std::vector<KidnapRun>& runs) {
  suites::Tallies<Tally> tallies;
  for (const KidnapRun& run : runs) tallies.Add(run.world, run);
  for (const KidnapRun& run : runs) {
    tallies.Add(run.is_warm ? "warm" : "cold", run);
  }
  for (const KidnapRun& run : runs) tallies.Add("all", run);
  return tallies;
}

std::string RunJson(const KidnapRun& run) {
  std::string json =
      suites::RunHeadJson(run, {"start", run.is_warm ? "\"warm\"" : "\"cold\""},
                          KidnapOutcomeName(run.outcome), run.IsGood());
  absl::StrAppendFormat(
      &json,
      "     \"real\": %s, \"goal\": %s, \"away_m\": %.3f, \"turned_deg\": "
      "%.1f, \"kidnap_s\": %.3f, \"noticed_after_s\": %.3f, "
      "\"recovery_s\": %.3f,\n",
      suites::PlacementJson(run.real), suites::PlacementJson(run.goal),
      run.away_m, run.turned_deg, run.kidnap_s, run.noticed_after_s,
      run.back_after_s);
  absl::StrAppendFormat(
      &json,
      "     \"error_at_resumption\": %s, \"resumptions\": %d, "
      "\"wrong_resumptions\": %d, \"questions\": %d, \"arrived\": %s,\n",
      suites::PoseMissJson(run.error_at_resumption), run.resumptions,
      run.wrong_resumptions, run.questions, run.arrived ? "true" : "false");
  absl::StrAppendFormat(&json, "     %s,\n     \"steps\": %s}",
                        suites::DriveJson(run),
                        suites::StepTimesJson(run.times));
  return json;
}

}  // namespace

int WrongResumptions(const std::vector<KidnapRun>& runs) {
  int wrong = 0;
  for (const KidnapRun& run : runs) wrong += run.wrong_resumptions;
  return wrong;
}

std::string KidnapSummary(const std::vector<KidnapRun>& runs, int expected) {
  std::string text =
      "                                          not    sear-               "
      "wrong        recovery (s) colli-\n"
      "                runs  back  late wrong  help noticed ching fell    "
      "back  went on arrived  p50    p95 sions\n";
  const suites::Tallies<Tally> tallies = TalliesOf(runs);
  for (const auto& [name, tally] : tallies.rows()) text += Row(name, tally);
  text += suites::NotRunText(runs.size(), expected, "kidnaps");
  for (const KidnapRun& run : runs) {
    if (run.IsGood()) continue;
    absl::StrAppendFormat(
        &text,
        "  %s seed %d (%s): %s (%s); noticed after %.1f s, back after %.1f s, "
        "error when it went on %.2f m, %.0f deg%s%s%s\n",
        run.world, run.seed, run.is_warm ? "warm" : "cold",
        KidnapOutcomeName(run.outcome), core::NavigationCauseName(run.cause),
        run.noticed_after_s, run.back_after_s,
        run.error_at_resumption.distance_m, run.error_at_resumption.turn_deg,
        run.why.empty() ? "" : "; ", run.why, suites::CollisionsText(run));
  }
  return text;
}

std::string KidnapJson(const std::vector<KidnapRun>& runs, int expected,
                       const KidnapConditions& conditions) {
  Tally all;
  int good = 0;
  for (const KidnapRun& run : runs) {
    all.Add(run);
    good += run.IsGood() ? 1 : 0;
  }
  std::string json = absl::StrFormat(
      "{\n  \"suite\": \"kidnaps\",\n  \"method\": %s,\n  \"server_fault\": "
      "%s,\n  \"light\": \"%s\",\n  \"map_light\": \"%s\",\n  "
      "\"rearranged\": {\"seed\": %d, \"share\": %g},\n  \"expected\": "
      "%d,\n  \"runs\": %d,\n  \"good\": %d,\n",
      base::JsonQuoted(conditions.method), base::JsonQuoted(conditions.fault),
      building::LightingName(conditions.lighting),
      building::LightingName(conditions.map_lighting),
      conditions.rearranged.seed, conditions.rearranged.share, expected,
      all.runs, good);
  for (size_t i = 0; i < kOutcomes.size(); ++i) {
    absl::StrAppendFormat(&json, "  \"%s\": %d,\n",
                          KidnapOutcomeName(kOutcomes[i]), all.outcomes[i]);
  }
  absl::StrAppendFormat(
      &json,
      "  \"wrong_resumptions\": %d,\n  \"arrived\": %d,\n"
      "  \"collisions_by_robot\": %d,\n  \"recovery_p50_s\": %.3f,\n"
      "  \"recovery_p95_s\": %.3f,\n  \"noticed_p50_s\": %.3f,\n"
      "  \"kidnaps\": ",
      all.wrong_resumptions, all.arrived, all.collisions_of_robot,
      suites::NearestQuantile(all.back_s, 0.5),
      suites::NearestQuantile(all.back_s, 0.95),
      suites::NearestQuantile(all.noticed_s, 0.5));
  return json + suites::RunsJson(runs, RunJson) + "\n}\n";
}

}  // namespace treeline::kidnaps

#include "evaluation/kidnaps/kidnap_report.h"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/missions/suite_report.h"

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

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<size_t>(
      share * static_cast<double>(values.size() - 1) + 0.5)];
}

std::string Row(const std::string& name, const Tally& tally) {
  std::string row = absl::StrFormat("%-14s %5d", name, tally.runs);
  for (const int count : tally.outcomes)
    absl::StrAppendFormat(&row, "%6d", count);
  absl::StrAppendFormat(
      &row, " %6.1f %% %6d %6d %6.1f %6.1f %5d\n",
      tally.runs > 0 ? 100.0 * tally.outcomes[0] / tally.runs : 0.0,
      tally.wrong_resumptions, tally.arrived, Quantile(tally.back_s, 0.5),
      Quantile(tally.back_s, 0.95), tally.collisions_of_robot);
  return row;
}

std::vector<std::pair<std::string, Tally>> TalliesOf(
    const std::vector<KidnapRun>& runs) {
  std::vector<std::pair<std::string, Tally>> tallies;
  const auto add = [&tallies](const std::string& name, const KidnapRun& run) {
    auto it =
        std::ranges::find(tallies, name, &std::pair<std::string, Tally>::first);
    if (it == tallies.end()) {
      it = tallies.insert(tallies.end(), {name, Tally()});
    }
    it->second.Add(run);
  };
  for (const KidnapRun& run : runs) add(run.world, run);
  for (const KidnapRun& run : runs) add(run.is_warm ? "warm" : "cold", run);
  for (const KidnapRun& run : runs) add("all", run);
  return tallies;
}

std::string RunJson(const KidnapRun& run) {
  std::string json = absl::StrFormat(
      "    {\"world\": %s, \"seed\": %d, \"start\": \"%s\", \"outcome\": "
      "\"%s\", \"good\": %s, \"cause\": \"%s\", \"why\": %s,\n",
      missions::JsonQuoted(run.world), run.seed, run.is_warm ? "warm" : "cold",
      KidnapOutcomeName(run.outcome), IsGood(run) ? "true" : "false",
      core::NavigationCauseName(run.cause), missions::JsonQuoted(run.why));
  absl::StrAppendFormat(
      &json,
      "     \"real\": %s, \"goal\": %s, \"away_m\": %.3f, \"turned_deg\": "
      "%.1f, \"kidnap_s\": %.3f, \"noticed_after_s\": %.3f, "
      "\"recovery_s\": %.3f,\n",
      missions::PlacementJson(run.real), missions::PlacementJson(run.goal),
      run.away_m, run.turned_deg, run.kidnap_s, run.noticed_after_s,
      run.back_after_s);
  absl::StrAppendFormat(
      &json,
      "     \"error_at_resumption\": %s, \"resumptions\": %d, "
      "\"wrong_resumptions\": %d, \"questions\": %d, \"arrived\": %s,\n",
      missions::PoseMissJson(run.error_at_resumption), run.resumptions,
      run.wrong_resumptions, run.questions, run.arrived ? "true" : "false");
  absl::StrAppendFormat(
      &json,
      "     \"simulated_s\": %.3f, \"path_m\": %.3f, \"collisions\": %d, "
      "\"collisions_by_robot\": %d, \"stair_entries\": %d, "
      "\"edge_entries\": %d,\n     \"steps\": %s}",
      run.simulated_s, run.driven_m, run.collisions, run.collisions_of_robot,
      run.stair_entries, run.edge_entries, missions::StepTimesJson(run.times));
  return json;
}

}  // namespace

bool IsGood(const KidnapRun& run) {
  return run.outcome == KidnapOutcome::kBack && run.wrong_resumptions == 0 &&
         run.collisions_of_robot == 0 && run.stair_entries == 0 &&
         run.edge_entries == 0;
}

double GoodShare(const std::vector<KidnapRun>& runs) {
  if (runs.empty()) return 0;
  return static_cast<double>(std::ranges::count_if(
             runs, [](const KidnapRun& run) { return IsGood(run); })) /
         static_cast<double>(runs.size());
}

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
  for (const auto& [name, tally] : TalliesOf(runs)) text += Row(name, tally);
  if (static_cast<int>(runs.size()) < expected) {
    absl::StrAppendFormat(&text, "%d of %d kidnaps were not run.\n",
                          expected - static_cast<int>(runs.size()), expected);
  }
  for (const KidnapRun& run : runs) {
    if (IsGood(run)) continue;
    absl::StrAppendFormat(
        &text,
        "  %s seed %d (%s): %s (%s); noticed after %.1f s, back after %.1f s, "
        "error when it went on %.2f m, %.0f deg%s%s%s\n",
        run.world, run.seed, run.is_warm ? "warm" : "cold",
        KidnapOutcomeName(run.outcome), core::NavigationCauseName(run.cause),
        run.noticed_after_s, run.back_after_s,
        run.error_at_resumption.distance_m, run.error_at_resumption.turn_deg,
        run.why.empty() ? "" : "; ", run.why,
        run.collisions_of_robot > 0
            ? absl::StrFormat("; %d collisions", run.collisions_of_robot)
            : "");
  }
  return text;
}

std::string KidnapJson(const std::vector<KidnapRun>& runs, int expected,
                       const std::string& method, const std::string& fault) {
  Tally all;
  int good = 0;
  for (const KidnapRun& run : runs) {
    all.Add(run);
    good += IsGood(run) ? 1 : 0;
  }
  std::string json = absl::StrFormat(
      "{\n  \"suite\": \"kidnaps\",\n  \"method\": %s,\n  \"server_fault\": "
      "%s,\n  \"expected\": %d,\n  \"runs\": %d,\n  \"good\": %d,\n",
      missions::JsonQuoted(method), missions::JsonQuoted(fault), expected,
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
      "  \"kidnaps\": [",
      all.wrong_resumptions, all.arrived, all.collisions_of_robot,
      Quantile(all.back_s, 0.5), Quantile(all.back_s, 0.95),
      Quantile(all.noticed_s, 0.5));
  const char* separator = "\n";
  for (const KidnapRun& run : runs) {
    absl::StrAppend(&json, separator, RunJson(run));
    separator = ",\n";
  }
  return json + "\n  ]\n}\n";
}

}  // namespace treeline::kidnaps

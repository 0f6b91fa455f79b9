#include "evaluation/accuracy/perturbation_table.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline::accuracy {
namespace {

constexpr size_t kNameWidth = 22;

std::string Percent(const std::optional<double>& share) {
  return share ? absl::StrFormat("%.1f", 100 * *share) : "-";
}

std::string Cells(const PerturbationRow& row) {
  const AnswerCounts& counts = row.counts;
  const std::string wrong =
      counts.gross == 0 ? absl::StrCat(counts.wrong)
                        : absl::StrCat(counts.wrong, " (", counts.gross, ")");
  return absl::StrFormat(
      " | %6s %6s %8s %8s", row.is_foreign ? "-" : Percent(counts.ShareRight()),
      row.is_foreign ? "-" : Percent(counts.ShareFound()), wrong,
      counts.latency_ms ? absl::StrFormat("%.2f", counts.latency_ms->p50)
                        : "-");
}

// A share of each method, in the column of right answers.
template <typename Share>
std::string ShareLine(
    absl::string_view name,
    const std::vector<std::vector<PerturbationRow>>& rows_of_methods,
    const Share& share) {
  std::string line = absl::StrFormat("%-*s", kNameWidth, name);
  for (const std::vector<PerturbationRow>& rows : rows_of_methods) {
    const std::optional<RightOverall> overall = RightOverRows(rows);
    absl::StrAppendFormat(&line, " | %6s %6s %8s %8s",
                          overall ? Percent(share(*overall)) : std::string("-"),
                          "", "", "");
  }
  return line + "\n";
}

}  // namespace

std::vector<PerturbationRow> PerturbationRows(const EvaluatedMethod& method,
                                              double confidence_threshold) {
  std::vector<PerturbationRow> rows;
  if (method.perturbed.empty()) return rows;
  // The scene's size is that of the frames as they are, for all of them.
  const PoseThreshold right_within = RightWithin(
      method.perturbed.front().results, method.model.units_are_metres);
  for (const PerturbedResults& perturbed : method.perturbed) {
    const bool is_foreign = perturbed.perturbation.is_foreign();
    rows.push_back({perturbed.perturbation.Name(), is_foreign,
                    is_foreign ? CountForeignAnswers(perturbed.results,
                                                     confidence_threshold)
                               : CountAnswers(perturbed.results, right_within,
                                              confidence_threshold)});
  }
  return rows;
}

std::optional<RightOverall> RightOverRows(
    const std::vector<PerturbationRow>& rows) {
  RightOverall overall{.mean = 0, .worst = 1};
  int count = 0;
  for (size_t i = 1; i < rows.size(); ++i) {
    const std::optional<double> share = rows[i].counts.ShareRight();
    if (rows[i].is_foreign || !share) continue;
    ++count;
    overall.mean += *share;
    overall.worst = std::min(overall.worst, *share);
  }
  if (count == 0) return std::nullopt;
  overall.mean /= count;
  return overall;
}

std::string PerturbationTable(const std::vector<EvaluatedMethod>& methods,
                              const EvaluationRun& run) {
  std::vector<std::vector<PerturbationRow>> rows_of_methods;
  std::string names = absl::StrFormat("%-*s", kNameWidth, "");
  std::string heads = absl::StrFormat("%-*s", kNameWidth, "perturbation");
  for (const EvaluatedMethod& method : methods) {
    if (!method.status.ok() || method.perturbed.empty()) continue;
    rows_of_methods.push_back(
        PerturbationRows(method, run.confidence_threshold));
    absl::StrAppendFormat(&names, " | %-31s", method.name);
    absl::StrAppendFormat(&heads, " | %6s %6s %8s %8s", "right%", "found%",
                          "wrong", "p50 ms");
  }
  if (rows_of_methods.empty()) return "";
  std::string table = absl::StrCat("\n", names, "\n", heads, "\n");
  for (size_t i = 0; i < rows_of_methods.front().size(); ++i) {
    absl::StrAppendFormat(&table, "%-*s", kNameWidth,
                          rows_of_methods.front()[i].name);
    for (const std::vector<PerturbationRow>& rows : rows_of_methods) {
      absl::StrAppend(&table, Cells(rows[i]));
    }
    absl::StrAppend(&table, "\n");
  }
  absl::StrAppend(
      &table,
      ShareLine("mean of the changed", rows_of_methods,
                [](const RightOverall& overall) { return overall.mean; }),
      ShareLine("worst", rows_of_methods,
                [](const RightOverall& overall) { return overall.worst; }));
  return table;
}

}  // namespace treeline::accuracy

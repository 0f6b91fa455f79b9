#include "evaluation/report/report_trust.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/report/report_line_charts.h"
#include "evaluation/report/report_parts.h"
#include "evaluation/report/report_svg.h"

namespace treeline::report {
namespace {

std::string ConfidenceCard(const accuracy::EvaluatedMethod& method,
                           const accuracy::ConfidenceReport& report) {
  const std::string figures = absl::StrFormat(
      "<p class=\"note\">At %.2f and above: %d answer%s, %s of them correct, "
      "which are %s of all correct ones. Expected calibration error %.3f.</p>",
      report.threshold, report.confident, report.confident == 1 ? "" : "s",
      PercentText(report.Precision()), PercentText(report.Recall()),
      *report.expected_calibration_error);
  return Card(EscapeHtml(method.name), ReliabilityChart(report) + figures);
}

// "0 of 55 (3 refused)".
std::string TallyCell(const accuracy::ForeignTally& tally) {
  if (tally.images == 0) return "<td class=\"n\">–</td>";
  std::string note;
  if (tally.refused > 0) note = absl::StrCat(tally.refused, " refused");
  if (tally.unreadable > 0) {
    absl::StrAppend(&note, note.empty() ? "" : ", ", tally.unreadable,
                    " unreadable");
  }
  return absl::StrFormat("<td class=\"n%s\">%d of %d%s</td>",
                         tally.accepted > 0 ? " bad" : "", tally.accepted,
                         tally.images,
                         note.empty() ? "" : absl::StrCat(" (", note, ")"));
}

// with_depth and without are two tallies of one source.
std::string ForeignRow(const accuracy::EvaluatedMethod& method,
                       const accuracy::ForeignTally& with_depth,
                       const accuracy::ForeignTally& without) {
  std::vector<std::string> notes = with_depth.accepted_names;
  notes.insert(notes.end(), without.accepted_names.begin(),
               without.accepted_names.end());
  notes.insert(notes.end(), with_depth.problems.begin(),
               with_depth.problems.end());
  return absl::StrCat("<tr><th>", EscapeHtml(method.name), "</th><td>",
                      EscapeHtml(DatasetName(with_depth.source)), "</td>",
                      TallyCell(with_depth), TallyCell(without), "<td>",
                      EscapeHtml(absl::StrJoin(notes, ", ")), "</td></tr>\n");
}

std::string ForeignTable(
    const std::vector<accuracy::EvaluatedMethod>& methods) {
  std::string rows;
  for (const accuracy::EvaluatedMethod& method : methods) {
    for (size_t i = 0; i + 1 < method.foreign.size(); i += 2) {
      absl::StrAppend(
          &rows, ForeignRow(method, method.foreign[i], method.foreign[i + 1]));
    }
  }
  if (rows.empty()) return "";
  return absl::StrCat(
      Heading("Pictures from elsewhere",
              "None of these shows the scene, so that every one must come back "
              "not localized: the figures count those that were falsely "
              "accepted. A method that needs depth refuses a picture without "
              "it."),
      "<div class=\"card scroll\"><table><thead><tr><th>method</th>"
      "<th>pictures</th><th class=\"n\">accepted, with depth</th>"
      "<th class=\"n\">accepted, without depth</th><th>which</th></tr>"
      "</thead><tbody>",
      rows, "</tbody></table></div>\n");
}

}  // namespace

std::string TrustSection(const std::vector<accuracy::EvaluatedMethod>& methods,
                         const accuracy::EvaluationRun& run) {
  std::string cards;
  for (const accuracy::EvaluatedMethod& method : methods) {
    const accuracy::ConfidenceReport report = accuracy::AssessConfidence(
        method.results, {}, run.confidence_threshold);
    if (report.stated) absl::StrAppend(&cards, ConfidenceCard(method, report));
  }
  if (!cards.empty()) {
    cards = absl::StrCat(
        Heading("Can it be believed",
                "The share of answers within 5 cm and 5°, by the confidence "
                "they came with. Bars on the dashed diagonal keep their word; "
                "the number above a bar is that of its frames."),
        "<div class=\"pair\">", cards, "</div>\n");
  }
  return cards + ForeignTable(methods);
}

}  // namespace treeline::report

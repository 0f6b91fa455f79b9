#include "evaluation/report/report_comparison.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/accuracy/method_spec.h"
#include "evaluation/accuracy/published_results.h"
#include "evaluation/accuracy/thresholds.h"
#include "evaluation/accuracy/trajectory_error.h"
#include "evaluation/report/report_line_charts.h"
#include "evaluation/report/report_parts.h"
#include "evaluation/report/report_svg.h"
#include "server/tools/model_description.h"

namespace treeline::report {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr double kTie = 1e-9;

// A column of the comparison: a number a method, of which the greatest or the
// least is best.
struct Column {
  std::string title;
  std::function<std::optional<double>(const accuracy::EvaluatedMethod&)> value;
  std::function<std::string(double)> text;
  bool greatest_is_best = false;
};

std::string Percents(double fraction) { return PercentText(fraction); }

std::function<std::string(double)> Printed(const char* format) {
  return [format](double value) { return tools::FormatNumber(format, value); };
}

std::vector<Column> AccuracyColumns(const accuracy::EvaluationRun& run) {
  std::vector<Column> columns;
  for (const accuracy::ThresholdRequest& request : run.thresholds) {
    columns.push_back(
        {accuracy::ThresholdText(request),
         [request](
             const accuracy::EvaluatedMethod& m) -> std::optional<double> {
           const auto threshold =
               accuracy::Resolve(request, accuracy::SceneSize_m(m.results));
           if (!threshold) return std::nullopt;
           return accuracy::CorrectShare(m.results, *threshold);
         },
         Percents, true});
  }
  columns.push_back(
      {"median cm",
       [](const accuracy::EvaluatedMethod& m) -> std::optional<double> {
         const auto s = accuracy::Summarize(m.results);
         if (!s.median_translation_m) return std::nullopt;
         return 100 * *s.median_translation_m;
       },
       Printed("%.2f")});
  columns.push_back(
      {"median °",
       [](const accuracy::EvaluatedMethod& m) {
         return accuracy::Summarize(m.results).median_rotation_deg;
       },
       Printed("%.2f")});
  columns.push_back(
      {"ATE cm",
       [](const accuracy::EvaluatedMethod& m) -> std::optional<double> {
         const auto error = accuracy::AbsoluteTrajectoryError(
             m.results, accuracy::TrajectoryAlignment::kRigid);
         if (!error) return std::nullopt;
         return 100 * error->rmse_m;
       },
       Printed("%.2f")});
  columns.push_back(
      {"localized",
       [](const accuracy::EvaluatedMethod& m) -> std::optional<double> {
         if (m.results.empty()) return std::nullopt;
         const auto s = accuracy::Summarize(m.results);
         return static_cast<double>(s.localized) / s.frames;
       },
       Percents, true});
  return columns;
}

std::vector<Column> CostColumns() {
  const auto latency = [](double accuracy::Percentiles::*p) {
    return [p](const accuracy::EvaluatedMethod& m) -> std::optional<double> {
      const auto s = accuracy::Summarize(m.results);
      if (!s.latency_ms) return std::nullopt;
      return (*s.latency_ms).*p;
    };
  };
  const auto bytes = [](double value) {
    return tools::FormatBytes(static_cast<uint64_t>(value));
  };
  return {{"p50 ms", latency(&accuracy::Percentiles::p50), Printed("%.1f")},
          {"p95 ms", latency(&accuracy::Percentiles::p95), Printed("%.1f")},
          {"p99 ms", latency(&accuracy::Percentiles::p99), Printed("%.1f")},
          {"model",
           [](const accuracy::EvaluatedMethod& m) -> std::optional<double> {
             return static_cast<double>(m.model.file_bytes);
           },
           bytes},
          {"memory",
           [](const accuracy::EvaluatedMethod& m) -> std::optional<double> {
             return static_cast<double>(m.peak_memory_bytes);
           },
           bytes},
          {"training s",
           [](const accuracy::EvaluatedMethod& m) -> std::optional<double> {
             return m.model.training_s;
           },
           Printed("%.1f")}};
}

// Falsely accepted pictures, where any were asked about.
std::optional<double> FalseAccepts(const accuracy::EvaluatedMethod& method) {
  if (method.foreign.empty()) return std::nullopt;
  double accepted = 0;
  for (const accuracy::ForeignTally& tally : method.foreign)
    accepted += tally.accepted;
  return accepted;
}

// "RGB-D / RGB".
std::string InputsText(const accuracy::EvaluatedMethod& method) {
  const accuracy::MethodInputs inputs =
      accuracy::InputsOfMethod(method.model.method);
  if (inputs.query.empty()) return "–";
  return absl::StrCat(inputs.training, " / ", inputs.query);
}

bool Better(const Column& column, double a, double b) {
  return column.greatest_is_best ? a > b + kTie : a < b - kTie;
}

std::string Table(const std::vector<accuracy::EvaluatedMethod>& methods,
                  const std::vector<Column>& columns) {
  std::string head = "<tr><th>method</th><th>training / query</th>";
  std::vector<std::optional<double>> best(columns.size());
  for (size_t c = 0; c < columns.size(); ++c) {
    absl::StrAppend(&head, "<th class=\"n\">", EscapeHtml(columns[c].title),
                    "</th>");
    for (const accuracy::EvaluatedMethod& method : methods) {
      if (!method.status.ok()) continue;
      const std::optional<double> value = columns[c].value(method);
      if (value && (!best[c] || Better(columns[c], *value, *best[c]))) {
        best[c] = value;
      }
    }
  }
  std::string rows;
  for (size_t i = 0; i < methods.size(); ++i) {
    const accuracy::EvaluatedMethod& method = methods[i];
    absl::StrAppend(&rows, "<tr><th><i class=\"swatch ", SeriesClass(i),
                    "\"></i>", EscapeHtml(method.name), "</th>");
    if (!method.status.ok()) {
      absl::StrAppend(&rows, "<td class=\"bad\" colspan=\"", columns.size() + 1,
                      "\">", EscapeHtml(std::string(method.status.message())),
                      "</td></tr>\n");
      continue;
    }
    absl::StrAppend(&rows, "<td>", InputsText(method), "</td>");
    for (size_t c = 0; c < columns.size(); ++c) {
      const std::optional<double> value = columns[c].value(method);
      const bool is_best =
          methods.size() > 1 && value && !Better(columns[c], *best[c], *value);
      absl::StrAppend(&rows, "<td class=\"n", is_best ? " best" : "", "\">",
                      value ? columns[c].text(*value) : "–", "</td>");
    }
    absl::StrAppend(&rows, "</tr>\n");
  }
  return absl::StrCat(
      "<div class=\"card scroll\"><table class=\"wide\"><thead>", head,
      "</tr></thead><tbody>", rows, "</tbody></table></div>\n");
}

std::string PoseCurves(const std::vector<accuracy::EvaluatedMethod>& methods) {
  std::vector<CurveValues> translations;
  std::vector<CurveValues> rotations;
  std::vector<std::string> names;
  for (const accuracy::EvaluatedMethod& method : methods) {
    const int scored = accuracy::Summarize(method.results).scored;
    CurveValues translation{method.name, {}, scored};
    CurveValues rotation{method.name, {}, scored};
    for (const accuracy::FrameResult& result : method.results) {
      if (!result.error) continue;
      translation.values.push_back(100 * result.error->translation_m);
      rotation.values.push_back(kDegreesPerRadian * result.error->rotation_rad);
    }
    translations.push_back(std::move(translation));
    rotations.push_back(std::move(rotation));
    names.push_back(method.name);
  }
  return absl::StrCat("<div class=\"pair after\">",
                      Card("Position: share of frames within",
                           CumulativeCurves(std::move(translations), 10, "cm",
                                            {{2, "2 cm"}, {5, "5 cm"}})),
                      Card("Orientation: share of frames within",
                           CumulativeCurves(std::move(rotations), 6, "degrees",
                                            {{2, "2°"}, {5, "5°"}})),
                      "</div>\n", SeriesLegend(names));
}

std::string PublishedRow(const accuracy::PublishedResult& result) {
  const auto number = [](const char* format,
                         const std::optional<double>& value) {
    return FormatOrDash(format, value);
  };
  return absl::StrFormat(
      "<tr class=\"published\"><th>%s</th><td>%s / %s</td>"
      "<td class=\"n\">%s</td><td class=\"n\">%s</td><td class=\"n\">%s</td>"
      "<td>published: %s%s%s</td></tr>\n",
      EscapeHtml(result.method), EscapeHtml(result.training),
      EscapeHtml(result.query), number("%.1f %%", result.correct_percent),
      number("%.1f", result.median_cm), number("%.2f", result.median_deg),
      EscapeHtml(result.source), result.note.empty() ? "" : "; ",
      EscapeHtml(result.note));
}

std::string OwnRow(const accuracy::EvaluatedMethod& method) {
  const accuracy::EvaluationSummary s = accuracy::Summarize(method.results);
  const std::optional<double> median_cm =
      s.median_translation_m ? std::optional(100 * *s.median_translation_m)
                             : std::nullopt;
  return absl::StrFormat(
      "<tr class=\"own\"><th>%s</th><td>%s</td><td class=\"n\">%s</td>"
      "<td class=\"n\">%s</td><td class=\"n\">%s</td>"
      "<td>measured here</td></tr>\n",
      EscapeHtml(method.name), InputsText(method),
      PercentText(s.correct_5cm_5deg), FormatOrDash("%.1f", median_cm),
      FormatOrDash("%.2f", s.median_rotation_deg));
}

std::string PublishedRows(const accuracy::PublishedTable& table,
                          const std::string& scene, const std::string& title) {
  std::vector<accuracy::PublishedResult> results =
      accuracy::ResultsFor(table, scene);
  if (results.empty()) return "";
  std::ranges::stable_sort(results, [](const auto& a, const auto& b) {
    return a.correct_percent.value_or(-1) > b.correct_percent.value_or(-1);
  });
  std::string rows = absl::StrCat("<tr class=\"group\"><th colspan=\"6\">",
                                  EscapeHtml(title), "</th></tr>\n");
  for (const accuracy::PublishedResult& result : results) {
    absl::StrAppend(&rows, PublishedRow(result));
  }
  return rows;
}

LineSeries SeriesOf(
    const accuracy::SweepLine& line,
    const std::function<std::optional<double>(const accuracy::SweepPoint&)>&
        value,
    const char* format) {
  LineSeries series{line.method, {}};
  for (const accuracy::SweepPoint& point : line.points) {
    const std::optional<double> y = value(point);
    if (!y) continue;
    series.points.push_back({static_cast<double>(point.value), *y,
                             absl::StrCat(line.method, ", ", point.value, ": ",
                                          tools::FormatNumber(format, *y))});
  }
  return series;
}

std::string SweepCards(const accuracy::Sweep& sweep) {
  std::vector<LineSeries> correct;
  std::vector<LineSeries> precise;
  std::vector<LineSeries> medians;
  std::vector<LineSeries> times;
  std::vector<std::string> names;
  for (const accuracy::SweepLine& line : sweep.lines) {
    const auto percent = [](const std::optional<double>& fraction) {
      return fraction ? std::optional(100 * *fraction) : std::nullopt;
    };
    correct.push_back(SeriesOf(
        line,
        [&](const accuracy::SweepPoint& p) {
          return percent(p.summary.correct_5cm_5deg);
        },
        "%.1f %%"));
    precise.push_back(SeriesOf(
        line,
        [&](const accuracy::SweepPoint& p) {
          return percent(p.summary.correct_2cm_2deg);
        },
        "%.1f %%"));
    medians.push_back(SeriesOf(
        line,
        [](const accuracy::SweepPoint& p) -> std::optional<double> {
          if (!p.summary.median_translation_m) return std::nullopt;
          return 100 * *p.summary.median_translation_m;
        },
        "%.2f cm"));
    times.push_back(SeriesOf(
        line,
        [](const accuracy::SweepPoint& p) -> std::optional<double> {
          if (!p.summary.cpu_ms) return std::nullopt;
          return p.summary.cpu_ms->p50;
        },
        "%.2f ms"));
    names.push_back(line.method);
  }
  const char* axis = accuracy::SweepAxis(sweep.variable);
  return absl::StrCat(
      "<div class=\"pair\">",
      Card("", LineChart(correct, axis, "% within 5 cm / 5°", 100)),
      Card("", LineChart(precise, axis, "% within 2 cm / 2°", 100)),
      Card("", LineChart(medians, axis, "median position error, cm")),
      Card("", LineChart(times, axis, "processor time, median ms")), "</div>\n",
      names.size() > 1 ? SeriesLegend(names) : "");
}

}  // namespace

std::string ComparisonVerdict(
    const std::vector<accuracy::EvaluatedMethod>& methods) {
  const accuracy::EvaluatedMethod* best = nullptr;
  std::optional<double> best_share;
  int failed = 0;
  for (const accuracy::EvaluatedMethod& method : methods) {
    failed += !method.status.ok();
    // More frames, then more of them within 2 cm.
    const accuracy::EvaluationSummary s = accuracy::Summarize(method.results);
    if (!s.correct_5cm_5deg) continue;
    const double share =
        *s.correct_5cm_5deg + 1e-6 * s.correct_2cm_2deg.value_or(0);
    if (best_share && share <= *best_share) continue;
    best = &method;
    best_share = share;
  }
  std::string text =
      absl::StrFormat("%d method%s side by side.", methods.size(),
                      methods.size() == 1 ? "" : "s");
  if (best != nullptr) {
    const accuracy::EvaluationSummary s = accuracy::Summarize(best->results);
    absl::StrAppendFormat(
        &text, " Most accurate: %s, with %s of %d frames within 5 cm and 5°.",
        EscapeHtml(best->name), PercentText(s.correct_5cm_5deg), s.scored);
  }
  if (failed > 0) {
    absl::StrAppendFormat(&text, " %d could not be evaluated.", failed);
  }
  return text;
}

std::string ComparisonSection(
    const std::vector<accuracy::EvaluatedMethod>& methods,
    const accuracy::EvaluationRun& run) {
  std::vector<Column> costs = CostColumns();
  const bool foreign = std::ranges::any_of(
      methods,
      [](const accuracy::EvaluatedMethod& m) { return !m.foreign.empty(); });
  if (foreign) {
    costs.push_back({"false accepts", FalseAccepts, Printed("%.0f")});
  }
  return absl::StrCat(
      Heading("Side by side",
              "Shares are of all frames with ground truth: what was not "
              "localized counts as wrong. Medians are over localized frames "
              "alone. ATE is the root mean square position error after rigid "
              "alignment. The best of a column is bold."),
      Table(methods, AccuracyColumns(run)), "<div class=\"after\">",
      Table(methods, costs), "</div>\n", PoseCurves(methods));
}

std::string SweepSection(const std::vector<accuracy::Sweep>& sweeps) {
  if (sweeps.empty()) return "";
  std::string html =
      Heading("What options buy",
              "The same frames with one option changed, all others as above.");
  for (const accuracy::Sweep& sweep : sweeps) {
    absl::StrAppend(&html, "<h3 class=\"sub\">",
                    accuracy::SweepAxis(sweep.variable), "</h3>\n",
                    SweepCards(sweep));
  }
  return html;
}

std::string PublishedSection(
    const std::vector<accuracy::EvaluatedMethod>& methods,
    const accuracy::EvaluationRun& run) {
  const std::optional<accuracy::PublishedTable> table =
      accuracy::PublishedFor(run.dataset_uri);
  if (!table) return "";
  std::string own;
  for (const accuracy::EvaluatedMethod& method : methods) {
    if (method.status.ok()) absl::StrAppend(&own, OwnRow(method));
  }
  const std::string scene = accuracy::SceneOf(*table, run.dataset_uri);
  return absl::StrCat(
      Heading(
          "What others published",
          absl::StrCat("Figures for ", EscapeHtml(table->dataset),
                       ", as published, with another protocol than ours: ",
                       EscapeHtml(table->protocol),
                       " The rows measured here are of this recording with the "
                       "frames and the ground truth named below, and cannot be "
                       "ranked against the others.")),
      "<div class=\"card scroll\"><table><thead><tr><th>method</th>"
      "<th>training / query</th><th class=\"n\">5 cm / 5°</th>"
      "<th class=\"n\">median cm</th><th class=\"n\">median °</th>"
      "<th>whose</th></tr></thead><tbody>",
      own,
      scene.empty()
          ? ""
          : PublishedRows(*table, scene, absl::StrCat("published, ", scene)),
      PublishedRows(*table, "average",
                    absl::StrCat("published, average over ", table->dataset)),
      "</tbody></table></div>\n");
}

}  // namespace treeline::report

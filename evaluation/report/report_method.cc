#include "evaluation/report/report_method.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/accuracy/thresholds.h"
#include "evaluation/accuracy/trajectory_error.h"
#include "evaluation/report/report_charts.h"
#include "evaluation/report/report_parts.h"
#include "evaluation/report/report_svg.h"
#include "evaluation/report/report_trajectory.h"
#include "evaluation/report/report_turntable.h"
#include "server/tools/model_description.h"

namespace treeline::report {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr int kWorstRows = 10;

std::vector<double> Values(const std::vector<accuracy::FrameResult>& results,
                           double (*value)(const geometry::PoseError&)) {
  std::vector<double> values;
  for (const accuracy::FrameResult& result : results) {
    if (result.error) values.push_back(value(*result.error));
  }
  return values;
}

std::string VerdictText(const accuracy::EvaluatedMethod& method,
                        const accuracy::EvaluationSummary& summary) {
  int within = 0;
  for (const accuracy::FrameResult& result : method.results) {
    within += accuracy::IsWithin(result, 0.05, 5);
  }
  std::string text;
  if (summary.scored == 0) {
    text = absl::StrFormat(
        "%d of %d frames were localized; the recording has "
        "no ground truth to score them by.",
        summary.localized, summary.frames);
  } else {
    text = absl::StrFormat("%d of %d frames were placed within 5 cm and 5°.",
                           within, summary.scored);
  }
  if (summary.frames > summary.scored && summary.scored > 0) {
    const int unknown = summary.frames - summary.scored;
    absl::StrAppendFormat(&text, " %d more %s no ground truth.", unknown,
                          unknown == 1 ? "has" : "have");
  }
  const int lost = summary.frames - summary.localized - summary.errors;
  absl::StrAppendFormat(
      &text, " %s",
      lost == 0 ? "None was given up as not localized."
      : lost == 1
          ? "One was given up as not localized."
          : absl::StrFormat("%d were given up as not localized.", lost));
  if (summary.errors > 0) {
    absl::StrAppendFormat(&text, " %d could not be read or used.",
                          summary.errors);
  }
  return text;
}

// Thresholds and trajectory errors as a table.
std::string FiguresTable(const accuracy::EvaluatedMethod& method,
                         const accuracy::EvaluationRun& run) {
  std::vector<tools::DescriptionRow> rows;
  const std::optional<double> size_m = accuracy::SceneSize_m(method.results);
  for (const accuracy::ThresholdRequest& request : run.thresholds) {
    const std::optional<accuracy::PoseThreshold> threshold =
        accuracy::Resolve(request, size_m);
    rows.emplace_back(absl::StrCat("within ", accuracy::ThresholdText(request)),
                      threshold ? PercentText(accuracy::CorrectShare(
                                      method.results, *threshold))
                                : "–");
  }
  const auto add = [&](const char* name,
                       accuracy::TrajectoryAlignment alignment) {
    const auto error =
        accuracy::AbsoluteTrajectoryError(method.results, alignment);
    std::string text = "–";
    if (error) text = absl::StrFormat("%.2f cm", 100 * error->rmse_m);
    if (error && alignment == accuracy::TrajectoryAlignment::kSimilarity) {
      absl::StrAppendFormat(&text, ", scale %.4f", error->scale);
    }
    rows.emplace_back(name, text);
  };
  add("trajectory RMSE", accuracy::TrajectoryAlignment::kNone);
  add("… after rigid alignment", accuracy::TrajectoryAlignment::kRigid);
  add("… after alignment with scale",
      accuracy::TrajectoryAlignment::kSimilarity);
  return RowsTable(rows);
}

std::string AccuracySection(const accuracy::EvaluatedMethod& method,
                            const accuracy::EvaluationSummary& summary,
                            const accuracy::EvaluationRun& run) {
  if (summary.scored == 0) return "";
  const std::string translation = CumulativeChart(
      Values(
          method.results,
          [](const geometry::PoseError& e) { return 100 * e.translation_m; }),
      summary.scored, 10, "cm", {{2, "2 cm"}, {5, "5 cm"}});
  const std::string rotation =
      CumulativeChart(Values(method.results,
                             [](const geometry::PoseError& e) {
                               return kDegreesPerRadian * e.rotation_rad;
                             }),
                      summary.scored, 6, "degrees", {{2, "2°"}, {5, "5°"}});
  return absl::StrCat(
      Heading("How far off",
              "The share of all frames with ground truth whose error is at "
              "most so large. Frames that were not localized never count as "
              "reached."),
      "<div class=\"pair\">", Card("Position", translation),
      Card("Orientation", rotation), "</div>\n<div class=\"after\">",
      Card("In figures", FiguresTable(method, run)), "</div>\n");
}

std::string Tooltip(const accuracy::FrameResult& result) {
  if (!result.status.ok()) return absl::StrCat(result.stem, ": error");
  if (!result.error) return absl::StrCat(result.stem, ": not localized");
  return absl::StrFormat("%s: %.1f cm, %.2f°, %d of %d inliers", result.stem,
                         100 * result.error->translation_m,
                         result.error->rotation_rad * kDegreesPerRadian,
                         result.estimate.inliers, result.estimate.samples);
}

std::vector<ErrorPoint> ErrorPoints(const accuracy::EvaluatedMethod& method,
                                    bool by_distance) {
  std::vector<ErrorPoint> points;
  for (size_t i = 0; i < method.results.size(); ++i) {
    const accuracy::FrameResult& result = method.results[i];
    if (!result.true_world_from_camera) continue;
    ErrorPoint point;
    point.x = static_cast<double>(i);
    point.tooltip = Tooltip(result);
    if (by_distance) {
      const auto nearest = accuracy::DistanceToTraining(
          *result.true_world_from_camera, method.training_poses);
      point.x = 100 * nearest->combined_m;
    }
    if (result.error) point.error = 100 * result.error->translation_m;
    point.good = accuracy::IsWithin(result, 0.05, 5);
    points.push_back(std::move(point));
  }
  return points;
}

constexpr const char* kDotLegend =
    "<ul class=\"legend\"><li><i></i>within 5 cm and 5°</li>"
    "<li><i class=\"bad\"></i>further off</li>"
    "<li><i class=\"cross\">×</i>not localized</li></ul>";

std::string FramesSection(const accuracy::EvaluatedMethod& method,
                          const accuracy::EvaluationSummary& summary) {
  if (summary.scored == 0) return "";
  const std::vector<ChartMark> marks{{2, "2 cm"}, {5, "5 cm"}};
  std::string html = absl::StrCat(
      Heading("Frame by frame",
              "The position error of every frame, in the order of the list, on "
              "a logarithmic scale. Point at a dot to see which frame it is."),
      Card("", absl::StrCat(ErrorChart(ErrorPoints(method, false),
                                       "frame in the list", "cm", true, marks),
                            kDotLegend)));
  if (method.training_poses.empty()) return html;
  absl::StrAppend(
      &html,
      Heading("Away from the training frames",
              "The same errors against the distance to the nearest training "
              "camera. A turn by one radian counts as 1.5 m: so far does what "
              "it sees move."),
      Card("", absl::StrCat(ErrorChart(ErrorPoints(method, true),
                                       "cm to the nearest training camera",
                                       "cm", false, marks),
                            kDotLegend)));
  return html;
}

std::string TrajectorySection(const accuracy::EvaluatedMethod& method,
                              absl::string_view id) {
  const std::string chart =
      TrajectoryChart(method.results, method.training_poses);
  if (chart.empty()) return "";
  const std::string legend = absl::StrCat(
      "<ul class=\"legend\"><li><i class=\"line\"></i>ground truth</li>"
      "<li><i></i>estimate</li>"
      "<li><i class=\"bad\"></i>estimate beyond 5 cm or 5°</li>",
      method.training_poses.empty()
          ? ""
          : "<li><i class=\"gray\"></i>training cameras</li>",
      "</ul>");
  return absl::StrCat(
      Heading("Where the camera was",
              "Ground truth and estimates at one scale, seen from above, with "
              "the average viewing direction upwards, and from the side. A "
              "short line joins an estimate with its truth; pyramids show "
              "every few frames where the camera looked."),
      Card("", chart + legend), "<div class=\"after\">",
      Card("In space",
           TurntableChart(method.results, method.training_poses, id) + legend),
      "</div>\n");
}

std::string PercentileRow(absl::string_view name,
                          const std::vector<double>& values) {
  if (values.empty()) return "";
  std::string row = absl::StrCat("<tr><th>", name, "</th>");
  for (double p : {50.0, 95.0, 99.0, 100.0}) {
    absl::StrAppendFormat(&row, "<td class=\"n\">%.2f</td>",
                          *accuracy::Percentile(values, p));
  }
  return row + "</tr>\n";
}

std::vector<double> Stage(const std::vector<accuracy::FrameResult>& results,
                          double localizer::LocalizeTimings::*stage) {
  std::vector<double> values;
  for (const accuracy::FrameResult& result : results) {
    if (result.status.ok()) values.push_back(result.estimate.timings.*stage);
  }
  return values;
}

std::string LatencySection(const accuracy::EvaluatedMethod& method,
                           const accuracy::EvaluationSummary& summary,
                           const accuracy::EvaluationRun& run) {
  if (!summary.latency_ms) return "";
  std::vector<double> latencies;
  std::vector<double> cpus;
  std::vector<double> decodes;
  for (const accuracy::FrameResult& result : method.results) {
    if (result.latency_ms) latencies.push_back(*result.latency_ms);
    if (result.cpu_ms) cpus.push_back(*result.cpu_ms);
    if (result.decode_ms) decodes.push_back(*result.decode_ms);
  }
  const accuracy::Percentiles& p = *summary.latency_ms;
  const std::string histogram =
      HistogramChart(latencies, "ms a query",
                     {{p.p50, absl::StrFormat("p50 %.1f", p.p50)},
                      {p.p95, absl::StrFormat("p95 %.1f", p.p95)},
                      {p.p99, absl::StrFormat("p99 %.1f", p.p99)}});
  const std::string table = absl::StrCat(
      "<div class=\"scroll\"><table><thead><tr><th>ms</th>"
      "<th class=\"n\">p50</th><th class=\"n\">p95</th><th class=\"n\">p99</th>"
      "<th class=\"n\">most</th></tr></thead><tbody>",
      PercentileRow(
          "samples and descriptors",
          Stage(method.results, &localizer::LocalizeTimings::sample_ms)),
      PercentileRow(
          "scene coordinates",
          Stage(method.results, &localizer::LocalizeTimings::forest_ms)),
      PercentileRow(
          "pose", Stage(method.results, &localizer::LocalizeTimings::pose_ms)),
      PercentileRow("whole query", latencies),
      PercentileRow("whole query, processor time", cpus),
      PercentileRow("decoding the images", decodes), "</tbody></table></div>");
  return absl::StrCat(
      Heading("How fast",
              absl::StrCat("The localizer alone; decoding comes on top. ",
                           run.threads, " frame", run.threads == 1 ? "" : "s",
                           " at a time on ", EscapeHtml(run.cpu), ".")),
      "<div class=\"pair\">", Card("Queries by latency", histogram),
      Card("Stages", table), "</div>\n");
}

std::string PicturesSection(const accuracy::EvaluatedMethod& method) {
  if (method.pictures.empty()) return "";
  std::string html = absl::StrCat(
      Heading("Pictures",
              "Each dot is a pixel whose place in the scene was predicted: "
              "green where the prediction agrees with the pose, red where it "
              "does not."),
      "<div class=\"photos\">\n");
  for (const accuracy::ReportPicture& picture : method.pictures) {
    absl::StrAppend(&html, accuracy::PictureHtml(picture, method.results,
                                                 method.training_poses));
  }
  return html + "</div>\n";
}

std::string WorstRow(const accuracy::FrameResult& result,
                     const std::vector<geometry::Rigid3>& training_poses) {
  std::string row = absl::StrCat("<tr><td>", EscapeHtml(result.stem), "</td>");
  if (!result.status.ok()) {
    return absl::StrCat(row, "<td class=\"bad\" colspan=\"5\">",
                        EscapeHtml(std::string(result.status.message())),
                        "</td></tr>\n");
  }
  if (result.error) {
    absl::StrAppendFormat(
        &row, "<td class=\"n%s\">%.1f cm</td><td class=\"n\">%.2f°</td>",
        accuracy::IsWithin(result, 0.05, 5) ? "" : " bad",
        100 * result.error->translation_m,
        kDegreesPerRadian * result.error->rotation_rad);
  } else {
    absl::StrAppend(&row, "<td class=\"n bad\" colspan=\"2\">",
                    accuracy::ReasonText(result.estimate.reason), "</td>");
  }
  absl::StrAppendFormat(
      &row, "<td class=\"n\">%d of %d</td><td class=\"n\">%.0f %%</td>",
      result.estimate.inliers, result.estimate.samples,
      100 * result.estimate.inlier_ratio);
  std::optional<accuracy::TrainingDistance> nearest;
  if (result.true_world_from_camera) {
    nearest = accuracy::DistanceToTraining(*result.true_world_from_camera,
                                           training_poses);
  }
  if (nearest) {
    absl::StrAppendFormat(&row, "<td class=\"n\">%.0f cm, %.0f°</td>",
                          100 * nearest->translation_m, nearest->rotation_deg);
  } else {
    absl::StrAppend(&row, "<td class=\"n\">–</td>");
  }
  return row + "</tr>\n";
}

std::string WorstSection(const accuracy::EvaluatedMethod& method) {
  std::vector<const accuracy::FrameResult*> worst;
  for (const accuracy::FrameResult& result : method.results) {
    if (result.status.ok() && result.localized() && !result.error) continue;
    worst.push_back(&result);
  }
  const auto badness = [](const accuracy::FrameResult* result) {
    if (!result->status.ok()) return 2e9;
    return result->error ? result->error->translation_m : 1e9;
  };
  std::ranges::stable_sort(worst, [&](const auto* a, const auto* b) {
    return badness(a) > badness(b);
  });
  if (worst.size() > kWorstRows) worst.resize(kWorstRows);
  if (worst.empty()) return "";
  std::string rows;
  for (const accuracy::FrameResult* result : worst) {
    absl::StrAppend(&rows, WorstRow(*result, method.training_poses));
  }
  return absl::StrCat(
      Heading("The hardest frames",
              "Errors and frames that were not localized first, then by "
              "position error."),
      "<div class=\"card scroll\"><table><thead><tr><th>frame</th>"
      "<th class=\"n\">position</th><th class=\"n\">orientation</th>"
      "<th class=\"n\">inliers</th><th class=\"n\">ratio</th>"
      "<th class=\"n\">nearest training camera</th></tr></thead><tbody>",
      rows, "</tbody></table></div>\n");
}

}  // namespace

std::string MethodVerdict(const accuracy::EvaluatedMethod& method) {
  return VerdictText(method, accuracy::Summarize(method.results));
}

std::string MethodTiles(const accuracy::EvaluatedMethod& method) {
  const accuracy::EvaluationSummary summary =
      accuracy::Summarize(method.results);
  std::string html = "<div class=\"tiles\">\n";
  const std::optional<double> median_cm =
      summary.median_translation_m
          ? std::optional<double>(100 * *summary.median_translation_m)
          : std::nullopt;
  absl::StrAppend(
      &html, Tile(PercentText(summary.correct_5cm_5deg), "within 5 cm and 5°"),
      Tile(PercentText(summary.correct_2cm_2deg), "within 2 cm and 2°"),
      Tile(absl::StrCat(FormatOrDash("%.2f", median_cm), " <small>cm</small>"),
           absl::StrCat("median error, and ",
                        FormatOrDash("%.2f", summary.median_rotation_deg),
                        "°")));
  if (summary.latency_ms) {
    absl::StrAppend(
        &html,
        Tile(absl::StrFormat("%.1f <small>ms</small>", summary.latency_ms->p50),
             absl::StrFormat("median, p99 %.1f ms", summary.latency_ms->p99)));
  }
  if (method.model.file_bytes > 0) {
    const std::string size = tools::FormatBytes(method.model.file_bytes);
    const size_t space = size.find(' ');
    absl::StrAppend(&html,
                    Tile(absl::StrCat(size.substr(0, space), " <small>",
                                      size.substr(space + 1), "</small>"),
                         absl::StrFormat("model, %.0f s to train",
                                         method.model.training_s)));
  }
  return html + "</div>\n";
}

std::string MethodSections(const accuracy::EvaluatedMethod& method,
                           const accuracy::EvaluationRun& run,
                           absl::string_view id) {
  const accuracy::EvaluationSummary summary =
      accuracy::Summarize(method.results);
  return absl::StrCat(
      AccuracySection(method, summary, run), FramesSection(method, summary),
      PicturesSection(method), TrajectorySection(method, id),
      LatencySection(method, summary, run), WorstSection(method));
}

}  // namespace treeline::report

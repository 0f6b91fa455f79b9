#include "evaluation/accuracy/evaluation_table.h"

#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/accuracy/thresholds.h"
#include "evaluation/accuracy/trajectory_error.h"
#include "server/tools/model_description.h"

namespace treeline::accuracy {
namespace {

constexpr int kErrorsShown = 5;

std::string Row(absl::string_view name, absl::string_view value) {
  return absl::StrFormat("%-24s %s\n", name, value);
}

std::string Percent(const std::optional<double>& fraction) {
  return fraction ? absl::StrFormat("%.1f %%", 100 * *fraction) : "-";
}

std::string Range(const std::optional<Percentiles>& ms) {
  if (!ms) return "-";
  return absl::StrFormat("p50 %.2f  p95 %.2f  p99 %.2f ms", ms->p50, ms->p95,
                         ms->p99);
}

std::string LengthText(const std::optional<dataset::TrajectoryError>& error,
                       const forest::ModelInfo& model) {
  if (!error) return "-";
  return model.units_are_metres
             ? absl::StrFormat("%.2f cm", 100 * error->position_m.rmse)
             : absl::StrFormat("%.5f units", error->position_m.rmse);
}

// Where the world's unit is arbitrary, it and the scale of the scene.
std::string MediansText(const EvaluationSummary& s,
                        const forest::ModelInfo& model) {
  if (!s.median_translation_m) return "-";
  if (model.units_are_metres) {
    return absl::StrFormat("%.2f cm  %.2f deg", 100 * *s.median_translation_m,
                           *s.median_rotation_deg);
  }
  std::string share;
  if (model.viewing_distance > 0) {
    share =
        absl::StrFormat(" (%.3f %% of the viewing distance)",
                        100 * *s.median_translation_m / model.viewing_distance);
  }
  return absl::StrFormat("%.5f units%s  %.4f deg", *s.median_translation_m,
                         share, *s.median_rotation_deg);
}

// Over all sources, with depth and without.
std::string ForeignText(const std::vector<NegativeTally>& tallies) {
  int images = 0;
  int accepted = 0;
  for (const NegativeTally& tally : tallies) {
    images += tally.images;
    accepted += tally.accepted;
  }
  return absl::StrCat(accepted, " of ", images);
}

std::string ConfidenceText(const ConfidenceReport& report) {
  if (!report.stated) return "not stated";
  return absl::StrFormat(
      "precision %s at %.2f (%d frames), calibration error %.3f",
      Percent(report.Precision()), report.threshold, report.confident,
      *report.expected_calibration_error);
}

std::string ErrorLines(const EvaluatedMethod& method, int errors) {
  std::string lines;
  int shown = 0;
  for (const FrameResult& result : method.results) {
    if (result.status.ok()) continue;
    if (++shown > kErrorsShown) {
      absl::StrAppend(&lines, "  ... and ", errors - kErrorsShown, " more\n");
      break;
    }
    absl::StrAppend(&lines, "  ", result.stem, ": ",
                    std::string(result.status.message()), "\n");
  }
  return lines;
}

}  // namespace

std::string EvaluationTable(const EvaluatedMethod& method,
                            const EvaluationRun& run) {
  const std::vector<FrameResult>& results = method.results;
  const EvaluationSummary s = Summarize(results);
  std::string frames = absl::StrCat(s.frames);
  if (s.scored < s.frames) {
    absl::StrAppend(&frames, ", ", s.frames - s.scored,
                    " without ground truth (not scored)");
  }
  std::string table =
      absl::StrCat(Row("method", method.model.method), Row("frames", frames),
                   Row("localized", absl::StrCat(s.localized)));
  const std::optional<double> size_m = SceneSize_m(results);
  for (const ThresholdRequest& request : run.thresholds) {
    // Centimetres mean nothing where the unit is not known.
    if (!request.relative && !method.model.units_are_metres) continue;
    const std::optional<PoseThreshold> threshold = Resolve(request, size_m);
    const std::string unit = request.relative ? "%" : "cm";
    absl::StrAppend(
        &table,
        Row(absl::StrFormat("within %g %s / %g deg", request.translation, unit,
                            request.rotation_deg),
            threshold ? Percent(CorrectShare(results, *threshold)) : "-"));
  }
  const auto trajectory = [&](dataset::TrajectoryAlignment alignment) {
    return LengthText(
        dataset::AbsoluteTrajectoryError(PosePairs(results), alignment),
        method.model);
  };
  absl::StrAppend(
      &table, Row("median error", MediansText(s, method.model)),
      Row("trajectory RMSE",
          absl::StrCat(
              trajectory(dataset::TrajectoryAlignment::kNone), ", aligned ",
              trajectory(dataset::TrajectoryAlignment::kRigid), ", with scale ",
              trajectory(dataset::TrajectoryAlignment::kSimilarity))),
      Row("confidence", ConfidenceText(AssessConfidence(
                            results, {}, run.confidence_threshold))));
  if (!method.foreign.empty()) {
    absl::StrAppend(&table,
                    Row("foreign, accepted", ForeignText(method.foreign)));
  }
  absl::StrAppend(
      &table, Row("latency", Range(s.latency_ms)),
      Row("processor time", Range(s.cpu_ms)),
      Row("  sampling", Range(s.sample_ms)),
      Row("  scene coordinates", Range(s.forest_ms)),
      Row("  pose", Range(s.pose_ms)), Row("decoding", Range(s.decode_ms)),
      Row("peak memory", tools::FormatBytes(method.peak_memory_bytes)),
      Row("model", tools::FormatBytes(method.model.file_bytes)),
      Row("training", tools::FormatNumber("%.1f s", method.model.training_s)));
  if (s.errors == 0) return table;
  return absl::StrCat(table, Row("errors", absl::StrCat(s.errors)),
                      ErrorLines(method, s.errors));
}

std::string ComparisonTable(const std::vector<EvaluatedMethod>& methods,
                            const EvaluationRun& run) {
  std::string table =
      absl::StrFormat("%-14s %8s %8s %20s %10s %9s %9s %9s %9s  %s\n", "method",
                      "5cm/5deg", "2cm/2deg", "median", "localized", "p50 ms",
                      "p99 ms", "model", "train", "foreign");
  std::string errors;
  for (const EvaluatedMethod& method : methods) {
    if (!method.status.ok()) {
      absl::StrAppendFormat(&table, "%-14s failed\n", method.name);
      continue;
    }
    const EvaluationSummary s = Summarize(method.results);
    const Percentiles latency = s.latency_ms.value_or(Percentiles{});
    absl::StrAppendFormat(
        &table, "%-14s %8s %8s %20s %10s %9.2f %9.2f %9s %9s  %s\n",
        method.name, Percent(s.correct_5cm_5deg), Percent(s.correct_2cm_2deg),
        MediansText(s, method.model), absl::StrCat(s.localized, "/", s.frames),
        latency.p50, latency.p99, tools::FormatBytes(method.model.file_bytes),
        tools::FormatNumber("%.1f s", method.model.training_s),
        method.foreign.empty() ? "-" : ForeignText(method.foreign));
    if (s.errors > 0) {
      absl::StrAppend(&errors, method.name, ": ", s.errors, " errors\n",
                      ErrorLines(method, s.errors));
    }
  }
  EvaluationSummary first;
  for (const EvaluatedMethod& method : methods) {
    if (first.frames == 0) first = Summarize(method.results);
  }
  return absl::StrCat(run.dataset_uri, ", ", first.frames, " frames, ",
                      first.scored, " with ground truth\n", table, errors);
}

std::string SweepTable(const std::vector<Sweep>& sweeps) {
  std::string table;
  for (const Sweep& sweep : sweeps) {
    for (const SweepLine& line : sweep.lines) {
      absl::StrAppendFormat(&table, "\n%s, %s\n%10s %8s %8s %20s %9s\n",
                            line.method, SweepName(sweep.variable), "value",
                            "5cm/5deg", "2cm/2deg", "median", "cpu ms");
      for (const SweepPoint& point : line.points) {
        const EvaluationSummary& s = point.summary;
        absl::StrAppendFormat(
            &table, "%10d %8s %8s %20s %9.2f\n", point.value,
            Percent(s.correct_5cm_5deg), Percent(s.correct_2cm_2deg),
            MediansText(s, forest::ModelInfo()), s.cpu_ms ? s.cpu_ms->p50 : 0);
      }
    }
  }
  return table;
}

}  // namespace treeline::accuracy

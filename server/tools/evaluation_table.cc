#include "server/tools/evaluation_table.h"

#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/tools/model_description.h"

namespace treeline {
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

// Where the world's unit is arbitrary, it and the scale of the scene.
std::string MediansText(const EvaluationSummary& s, const ModelInfo& model) {
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

}  // namespace

std::string EvaluationTable(const std::vector<FrameResult>& results,
                            const ModelInfo& model) {
  const EvaluationSummary s = Summarize(results);
  std::string frames = absl::StrCat(s.frames);
  if (s.scored < s.frames) {
    absl::StrAppend(&frames, ", ", s.frames - s.scored,
                    " without ground truth (not scored)");
  }
  std::string table = absl::StrCat(
      Row("method", model.method), Row("frames", frames),
      Row("localized", absl::StrCat(s.localized)),
      model.units_are_metres
          ? absl::StrCat(
                Row("within 5 cm / 5 deg", Percent(s.correct_5cm_5deg)),
                Row("within 2 cm / 2 deg", Percent(s.correct_2cm_2deg)))
          : "",
      Row("median error", MediansText(s, model)),
      Row("latency", Range(s.latency_ms)),
      Row("processor time", Range(s.cpu_ms)),
      Row("decoding", Range(s.decode_ms)),
      Row("model", FormatBytes(model.file_bytes)),
      Row("training", FormatNumber("%.1f s", model.training_s)));
  if (s.errors == 0) return table;
  absl::StrAppend(&table, Row("errors", absl::StrCat(s.errors)));
  int shown = 0;
  for (const FrameResult& result : results) {
    if (result.status.ok()) continue;
    if (++shown > kErrorsShown) {
      absl::StrAppend(&table, "  ... and ", s.errors - kErrorsShown, " more\n");
      break;
    }
    absl::StrAppend(&table, "  ", result.stem, ": ",
                    std::string(result.status.message()), "\n");
  }
  return table;
}

}  // namespace treeline

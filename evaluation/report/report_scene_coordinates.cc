#include "evaluation/report/report_scene_coordinates.h"

#include <algorithm>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/report/report_line_charts.h"
#include "evaluation/report/report_parts.h"
#include "evaluation/report/report_svg.h"

namespace treeline::report {
namespace {

constexpr int kRampSteps = 12;

std::string Curves(const std::vector<accuracy::EvaluatedMethod>& methods) {
  std::vector<CurveValues> curves;
  std::vector<std::string> names;
  bool any = false;
  for (const accuracy::EvaluatedMethod& method : methods) {
    CurveValues curve{
        .name = method.name,
        .values = {},
        .total = static_cast<int64_t>(method.scene_errors_m.size())};
    for (double error_m : method.scene_errors_m) {
      curve.values.push_back(100 * error_m);
    }
    any |= !curve.values.empty();
    names.push_back(method.name);
    curves.push_back(std::move(curve));
  }
  if (!any) return "";
  return Card("Predictions within a distance of the truth",
              CumulativeCurves(std::move(curves), 40, "cm",
                               {{5, "5 cm"}, {10, "10 cm"}}) +
                  (methods.size() > 1 ? SeriesLegend(names) : ""));
}

std::string Splits(const std::vector<accuracy::EvaluatedMethod>& methods) {
  std::string cards;
  std::vector<std::string> checksums;
  for (const accuracy::EvaluatedMethod& method : methods) {
    // Ablations may share a model.
    if (method.splits.empty() ||
        std::ranges::count(checksums, method.model.checksum) > 0) {
      continue;
    }
    checksums.push_back(method.model.checksum);
    absl::StrAppend(
        &cards,
        Card(absl::StrCat("Share of samples that go left, by level",
                          methods.size() > 1
                              ? absl::StrCat(": ", EscapeHtml(method.name))
                              : ""),
             SplitRatioMap(method.splits)));
  }
  return cards;
}

std::string Ramp() {
  std::string html = "<p class=\"ramp\">0 ";
  for (int k = 0; k < kRampSteps; ++k) {
    absl::StrAppendFormat(&html, "<i style=\"background:%s\"></i>",
                          accuracy::HeatColor((k + 0.5) / kRampSteps));
  }
  return absl::StrCat(html, absl::StrFormat(" %g cm and more</p>\n",
                                            100 * accuracy::kHeatMapMax_m));
}

std::string Picture(const accuracy::ErrorHeatMap& map, const std::string& jpeg,
                    const std::string& caption) {
  return absl::StrFormat(
      "<figure><img class=\"photo\" alt=\"%s\" width=\"%d\" height=\"%d\" "
      "src=\"data:image/jpeg;base64,%s\"><figcaption>%s</figcaption>"
      "</figure>\n",
      EscapeHtml(map.stem), map.width, map.height, absl::Base64Escape(jpeg),
      caption);
}

std::string HeatMaps(const std::vector<accuracy::EvaluatedMethod>& methods) {
  std::string html;
  std::vector<std::string> stems;
  for (const accuracy::EvaluatedMethod& method : methods) {
    for (const accuracy::ErrorHeatMap& map : method.heat_maps) {
      if (std::ranges::count(stems, map.stem) == 0) stems.push_back(map.stem);
    }
  }
  for (const std::string& stem : stems) {
    std::string row;
    for (const accuracy::EvaluatedMethod& method : methods) {
      for (const accuracy::ErrorHeatMap& map : method.heat_maps) {
        if (map.stem != stem) continue;
        if (row.empty()) {
          row = Picture(map, map.photo_jpeg,
                        absl::StrCat("<b>", EscapeHtml(stem), "</b>"));
        }
        absl::StrAppend(
            &row, Picture(map, map.map_jpeg,
                          absl::StrFormat("<b>%s</b> median %.1f cm of %d "
                                          "predictions",
                                          EscapeHtml(method.name),
                                          100 * map.median_error_m,
                                          map.predictions)));
      }
    }
    absl::StrAppend(&html, "<div class=\"photos maps\">\n", row, "</div>\n");
  }
  if (html.empty()) return "";
  return absl::StrCat(
      "<h3 class=\"sub\">Where in the picture predictions go wrong</h3>\n"
      "<p class=\"about\">Pixels with depth, sampled densely, by the distance "
      "of their predicted place from the true one. Grey: not asked, or no "
      "depth to check by.</p>\n",
      Ramp(), html);
}

}  // namespace

std::string SceneCoordinatesSection(
    const std::vector<accuracy::EvaluatedMethod>& methods) {
  const std::string maps = HeatMaps(methods);
  const std::string curves = Curves(methods);
  const std::string splits = Splits(methods);
  if (curves.empty() && splits.empty() && maps.empty()) return "";
  return absl::StrCat(
      Heading(
          "Before the pose",
          "Scene coordinates as they were predicted, against recorded "
          "depth and true poses (baselines predict only where a feature was "
          "matched, forests wherever there is a sample); and how evenly the "
          "splits of the forest "
          "divide what they were trained on: levels under the balanced "
          "objective keep near one half. (Deep down, where two samples "
          "can only be halved, one half stands out again.)"),
      "<div class=\"pair\">", curves, splits, "</div>\n", maps);
}

}  // namespace treeline::report

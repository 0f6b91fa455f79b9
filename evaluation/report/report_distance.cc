#include "evaluation/report/report_distance.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/accuracy/report_pictures.h"
#include "evaluation/report/report_line_charts.h"
#include "evaluation/report/report_parts.h"

namespace treeline::report {
namespace {

constexpr size_t kGroups = 5;

struct FrameAtDistance {
  double distance_cm = 0;
  const accuracy::FrameResult* result = nullptr;
};

// Scored frames, nearest to a training camera first.
std::vector<FrameAtDistance> ByDistance(
    const accuracy::EvaluatedMethod& method) {
  std::vector<FrameAtDistance> frames;
  for (const accuracy::FrameResult& result : method.results) {
    if (!result.true_world_from_camera) continue;
    const auto nearest = accuracy::DistanceToTraining(
        *result.true_world_from_camera, method.training_poses);
    if (nearest) frames.push_back({100 * nearest->combined_m, &result});
  }
  std::ranges::stable_sort(frames, {}, &FrameAtDistance::distance_cm);
  return frames;
}

// Adds a point a group to both lines.
void AddGroups(const accuracy::EvaluatedMethod& method, LineSeries& share,
               LineSeries& median) {
  const std::vector<FrameAtDistance> frames = ByDistance(method);
  const size_t groups = std::min(kGroups, frames.size());
  for (size_t g = 0; g < groups; ++g) {
    const size_t begin = g * frames.size() / groups;
    const size_t end = (g + 1) * frames.size() / groups;
    double distance_cm = 0;
    int correct = 0;
    std::vector<double> errors_cm;
    for (size_t i = begin; i < end; ++i) {
      const accuracy::FrameResult& result = *frames[i].result;
      distance_cm += frames[i].distance_cm / static_cast<double>(end - begin);
      correct += accuracy::IsWithin(result, accuracy::PoseThreshold{});
      if (result.error) errors_cm.push_back(100 * result.error->translation_m);
    }
    const double percent = 100.0 * correct / static_cast<double>(end - begin);
    share.points.push_back(
        {distance_cm, percent,
         absl::StrFormat("%s: %.1f %% of %d frames about %.0f cm away",
                         method.name, percent, end - begin, distance_cm)});
    if (errors_cm.empty()) continue;
    const double error_cm = *accuracy::Percentile(std::move(errors_cm), 50);
    median.points.push_back(
        {distance_cm, error_cm,
         absl::StrFormat("%s: median %.2f cm about %.0f cm away", method.name,
                         error_cm, distance_cm)});
  }
}

}  // namespace

std::string DistanceSection(
    const std::vector<accuracy::EvaluatedMethod>& methods) {
  std::vector<LineSeries> shares;
  std::vector<LineSeries> medians;
  std::vector<std::string> names;
  bool any = false;
  for (const accuracy::EvaluatedMethod& method : methods) {
    LineSeries share{method.name, {}};
    LineSeries median{method.name, {}};
    AddGroups(method, share, median);
    any |= !share.points.empty();
    shares.push_back(std::move(share));
    medians.push_back(std::move(median));
    names.push_back(method.name);
  }
  if (!any) return "";
  const char* axis = "cm to the nearest training camera";
  return absl::StrCat(
      Heading("Away from the training frames",
              "Five groups of as many frames, by their distance from the "
              "nearest training camera, at which a turn by one radian counts "
              "as 1.5 m. Medians are over localized frames alone."),
      "<div class=\"pair\">",
      Card("", LineChart(shares, axis, "% within 5 cm / 5°", 100)),
      Card("", LineChart(medians, axis, "median position error, cm")),
      "</div>\n", SeriesLegend(names));
}

}  // namespace treeline::report

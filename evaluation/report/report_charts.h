// Charts as SVG text for the evaluation's page. Colours come from the page's
// style sheet by class, so that they follow its light and dark themes.
#ifndef EVALUATION_REPORT_REPORT_CHARTS_H_
#define EVALUATION_REPORT_REPORT_CHARTS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::report {

// A vertical or horizontal line across a chart, with a word beside it.
struct ChartMark {
  double value = 0;
  std::string label;
};

// The share of `total` frames (in per cent, upwards) whose value is at most x
// (to the right), for x in [0, x_max]. Frames without a value count in total.
std::string CumulativeChart(std::vector<double> values, int total, double x_max,
                            absl::string_view unit,
                            const std::vector<ChartMark>& marks);

// How often values fall into equal bins from 0 to a little beyond the 99th
// percentile; what lies beyond is counted in the last bin, which says so.
std::string HistogramChart(const std::vector<double>& values,
                           absl::string_view unit,
                           const std::vector<ChartMark>& marks);

// One frame of an error chart.
struct ErrorPoint {
  double x = 0;
  // nullopt: not localized, or an error; drawn as a cross at the top.
  std::optional<double> error;
  std::string tooltip;
  bool good = false;
};

// Errors upwards on a logarithmic axis, x to the right: by frame, or against
// a distance. marks: horizontal.
std::string ErrorChart(const std::vector<ErrorPoint>& points,
                       absl::string_view x_label, absl::string_view y_unit,
                       bool x_is_integer, const std::vector<ChartMark>& marks);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_CHARTS_H_

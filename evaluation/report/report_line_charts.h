// Charts of several lines, for comparisons and sweeps, as SVG text. Line i has
// the style sheet's colour SeriesClass(i).
#ifndef EVALUATION_REPORT_REPORT_LINE_CHARTS_H_
#define EVALUATION_REPORT_REPORT_LINE_CHARTS_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/accuracy/split_ratios.h"
#include "evaluation/report/report_charts.h"

namespace treeline::report {

// The class of line i: "s0" to "s7", then from the beginning with dashes.
std::string SeriesClass(size_t i);

// Names and colours of the lines, as an HTML list.
std::string SeriesLegend(const std::vector<std::string>& names);

// Values of one method, and how many there would be if none were missing.
struct CurveValues {
  std::string name;
  std::vector<double> values;
  int64_t total = 0;
};

// For each, the share of its total (in per cent, upwards) that is at most x.
std::string CumulativeCurves(std::vector<CurveValues> curves, double x_max,
                             absl::string_view unit,
                             const std::vector<ChartMark>& marks);

struct LinePoint {
  double x = 0;
  double y = 0;
  std::string tooltip;
};
struct LineSeries {
  std::string name;
  std::vector<LinePoint> points;  // in ascending x
};

// Lines through points. Upwards from 0 or, if the values leave much room below
// them, from near the least of them; to y_limit at most, which no value may
// exceed.
std::string LineChart(const std::vector<LineSeries>& series,
                      absl::string_view x_label, absl::string_view y_label,
                      double y_limit = 1e300);

// Stated confidence to the right, the share that is correct upwards, a bar a
// bin; the diagonal is perfect. Empty if nothing is stated.
std::string ReliabilityChart(const accuracy::ConfidenceReport& report);

// Levels to the right, the share of samples that go left upwards; dark where
// many splits of the level have that share (thesis Fig. 4.9).
std::string SplitRatioMap(const std::vector<accuracy::LevelSplits>& levels);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_LINE_CHARTS_H_

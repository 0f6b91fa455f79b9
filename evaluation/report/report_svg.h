// What charts are drawn with: SVG text for the evaluation's page.
#ifndef EVALUATION_REPORT_REPORT_SVG_H_
#define EVALUATION_REPORT_REPORT_SVG_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::report {

// A drawing area with its margins, and the mapping into it (px).
struct Plot {
  double width = 540;
  double height = 270;
  double left = 46;
  double right = 14;
  double top = 16;
  double bottom = 40;
  double x_max = 1;

  double inner_width() const { return width - left - right; }
  double inner_height() const { return height - top - bottom; }
  double base() const { return height - bottom; }
  double X(double x) const { return left + inner_width() * x / x_max; }
  // fraction in [0, 1] of the height, from below.
  double Y(double fraction) const { return base() - inner_height() * fraction; }
};

// The opening tag of a chart.
std::string OpenSvg(const Plot& plot, absl::string_view title);

std::string SvgLine(double x1, double y1, double x2, double y2,
                    absl::string_view css);

// anchor: start, middle or end.
std::string SvgText(double x, double y, absl::string_view anchor,
                    absl::string_view css, absl::string_view text);

// The horizontal axis with its ticks and, below it at the right, its label.
std::string XAxis(const Plot& plot, absl::string_view label);

// Lines at quarters of the height, from 0 to 100 %.
std::string PercentGrid(const Plot& plot);

// Text as HTML and SVG take it.
std::string EscapeHtml(absl::string_view text);

// Round steps (1, 2 or 5 times a power of ten) from 0 to at most `max`, about
// `count` of them. max > 0.
std::vector<double> RoundTicks(double max, int count);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_SVG_H_

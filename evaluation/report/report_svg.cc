#include "evaluation/report/report_svg.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"

namespace treeline::report {

std::string EscapeHtml(absl::string_view text) {
  return absl::StrReplaceAll(text, {{"&", "&amp;"},
                                    {"<", "&lt;"},
                                    {">", "&gt;"},
                                    {"\"", "&quot;"},
                                    {"'", "&#39;"}});
}

std::vector<double> RoundTicks(double max, int count) {
  const double rough = max / count;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * 0.999) {
      step = factor * power;
      break;
    }
  }
  std::vector<double> ticks;
  for (int i = 0; i * step <= max * 1.0001; ++i) ticks.push_back(i * step);
  return ticks;
}

std::string OpenSvg(const Plot& plot, absl::string_view title) {
  return absl::StrFormat(
      "<svg class=\"chart%s\" viewBox=\"0 0 %g %g\" role=\"img\" "
      "aria-label=\"%s\">\n",
      plot.width > 600 ? " wide" : "", plot.width, plot.height,
      EscapeHtml(title));
}

std::string SvgLine(double x1, double y1, double x2, double y2,
                    absl::string_view css) {
  return absl::StrFormat(
      "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" "
      "class=\"%s\"/>\n",
      x1, y1, x2, y2, css);
}

std::string SvgText(double x, double y, absl::string_view anchor,
                    absl::string_view css, absl::string_view text) {
  return absl::StrFormat(
      "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" class=\"%s\">%s</text>\n",
      x, y, anchor, css, EscapeHtml(text));
}

std::string XAxis(const Plot& plot, absl::string_view label) {
  std::string svg = SvgLine(plot.left, plot.base(), plot.width - plot.right,
                            plot.base(), "axis");
  for (double tick : RoundTicks(plot.x_max, 6)) {
    absl::StrAppend(&svg,
                    SvgLine(plot.X(tick), plot.base(), plot.X(tick),
                            plot.base() + 4, "axis"),
                    SvgText(plot.X(tick), plot.base() + 17, "middle", "tick",
                            absl::StrFormat("%g", tick)));
  }
  absl::StrAppend(&svg, SvgText(plot.width - plot.right, plot.base() + 34,
                                "end", "label", label));
  return svg;
}

std::string PercentGrid(const Plot& plot) {
  std::string svg;
  for (int percent : {0, 25, 50, 75, 100}) {
    const double y = plot.Y(percent / 100.0);
    if (percent > 0) {
      absl::StrAppend(
          &svg, SvgLine(plot.left, y, plot.width - plot.right, y, "grid"));
    }
    absl::StrAppend(&svg,
                    SvgText(plot.left - 8, y + 4, "end", "tick",
                            absl::StrCat(percent, percent == 100 ? " %" : "")));
  }
  return svg;
}

}  // namespace treeline::report

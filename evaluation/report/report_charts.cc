#include "evaluation/report/report_charts.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/accuracy/evaluation.h"
#include "evaluation/report/report_svg.h"

namespace treeline::report {
namespace {

// Vertical marks with their words at the top, to the right of the line, one
// below the other: they may stand close.
std::string VerticalMarks(const Plot& plot,
                          const std::vector<ChartMark>& marks) {
  std::string lines;
  std::string words;
  double y = plot.top + 10;
  for (const ChartMark& mark : marks) {
    const double x = plot.X(mark.value);
    const bool flip = x > plot.width - 90;
    absl::StrAppend(&lines, SvgLine(x, plot.top, x, plot.base(), "mark"));
    absl::StrAppend(&words,
                    SvgText(flip ? x - 5 : x + 5, y, flip ? "end" : "start",
                            "marklabel", mark.label));
    y += 15;
  }
  return lines + words;
}

// The logarithmic vertical axis of an error chart. Its ends are 1, 2 or 5 times
// a power of ten.
struct LogAxis {
  double low = 0.1;
  double high = 10;
  double Fraction(double value) const {
    return std::clamp(
        std::log(std::max(value, 1e-12) / low) / std::log(high / low), 0.0,
        1.0);
  }
};

// 1, 2 and 5 times the powers of ten that cover [low, high]: from the last one
// that is at most low to the first one that is at least high.
std::vector<double> LogTicks(double low, double high) {
  std::vector<double> ticks;
  const int first = static_cast<int>(std::floor(std::log10(low)));
  for (int power = first; ticks.empty() || ticks.back() < high; ++power) {
    for (double factor : {1.0, 2.0, 5.0}) {
      const double tick = factor * std::pow(10, power);
      if (tick <= low) ticks.clear();
      if (ticks.empty() || ticks.back() < high) ticks.push_back(tick);
    }
  }
  return ticks;
}

LogAxis LogAxisFor(const std::vector<ErrorPoint>& points,
                   const std::vector<ChartMark>& marks) {
  std::vector<double> values;
  for (const ErrorPoint& point : points) {
    if (point.error && *point.error > 0) values.push_back(*point.error);
  }
  for (const ChartMark& mark : marks) values.push_back(mark.value);
  if (values.empty()) return {};
  // A single lucky frame must not stretch the axis downwards.
  const std::vector<double> ticks = LogTicks(*accuracy::Percentile(values, 1),
                                             *std::ranges::max_element(values));
  return {ticks.front(), std::max(ticks.back(), 2 * ticks.front())};
}

std::string LogGrid(const Plot& plot, const LogAxis& axis,
                    absl::string_view unit) {
  std::string svg;
  const std::vector<double> ticks = LogTicks(axis.low, axis.high);
  const bool powers_only = axis.high / axis.low > 3000;
  for (double tick : ticks) {
    const double power = std::log10(tick);
    if (powers_only && std::abs(power - std::round(power)) > 1e-9) continue;
    const double y = plot.Y(axis.Fraction(tick));
    if (tick > axis.low) {
      absl::StrAppend(
          &svg, SvgLine(plot.left, y, plot.width - plot.right, y, "grid"));
    }
    absl::StrAppend(&svg, SvgText(plot.left - 8, y + 4, "end", "tick",
                                  absl::StrFormat("%g%s", tick,
                                                  tick == ticks.back()
                                                      ? absl::StrCat(" ", unit)
                                                      : "")));
  }
  return svg;
}

std::string ErrorDot(const Plot& plot, const LogAxis& axis,
                     const ErrorPoint& point) {
  const double x = plot.X(point.x);
  const std::string title =
      absl::StrCat("<title>", EscapeHtml(point.tooltip), "</title>");
  if (!point.error) {
    return absl::StrFormat(
        "<path d=\"M%.1f %.1fl7 7m0 -7l-7 7\" class=\"lost\">%s</path>\n",
        x - 3.5, plot.top - 3.5, title);
  }
  return absl::StrFormat(
      "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.1\" class=\"%s\">%s</circle>\n", x,
      plot.Y(axis.Fraction(*point.error)), point.good ? "dot good" : "dot bad",
      title);
}

}  // namespace

std::string CumulativeChart(std::vector<double> values, int total, double x_max,
                            absl::string_view unit,
                            const std::vector<ChartMark>& marks) {
  const Plot plot{.x_max = x_max};
  std::ranges::sort(values);
  std::string svg =
      absl::StrCat(OpenSvg(plot, absl::StrCat("Cumulative error in ", unit)),
                   PercentGrid(plot), XAxis(plot, unit));
  std::string path = absl::StrFormat("M%.1f %.1f", plot.X(0), plot.Y(0));
  double share = 0;
  for (size_t i = 0; i < values.size() && values[i] <= x_max; ++i) {
    share = static_cast<double>(i + 1) / std::max(total, 1);
    absl::StrAppendFormat(&path, "H%.1fV%.1f", plot.X(values[i]),
                          plot.Y(share));
  }
  absl::StrAppendFormat(&path, "H%.1f", plot.X(x_max));
  absl::StrAppendFormat(&svg, "<path d=\"%sV%.1fZ\" class=\"area\"/>\n", path,
                        plot.base());
  absl::StrAppendFormat(&svg, "<path d=\"%s\" class=\"curve\"/>\n", path);
  for (const ChartMark& mark : marks) {
    const auto within = std::ranges::lower_bound(values, mark.value);
    const double at =
        static_cast<double>(within - values.begin()) / std::max(total, 1);
    const double x = plot.X(mark.value);
    // The words stand under the curve where there is room, else at the top.
    const double label_y = at > 0.3 ? plot.base() - 24 : plot.top + 10;
    absl::StrAppend(
        &svg, SvgLine(x, plot.top, x, plot.base(), "mark"),
        absl::StrFormat("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" "
                        "class=\"knot\"/>\n",
                        x, plot.Y(at)),
        SvgText(x + 7, label_y, "start", "value",
                absl::StrFormat("%.1f %%", 100 * at)),
        SvgText(x + 7, label_y + 14, "start", "marklabel", mark.label));
  }
  return svg + "</svg>\n";
}

std::string HistogramChart(const std::vector<double>& values,
                           absl::string_view unit,
                           const std::vector<ChartMark>& marks) {
  if (values.empty()) return "";
  const double high = std::max(1.25 * *accuracy::Percentile(values, 99), 1e-3);
  const std::vector<double> ticks = RoundTicks(high, 6);
  const Plot plot{
      .left = 14,
      .x_max = ticks.back() >= high ? ticks.back() : ticks.back() + ticks[1]};
  constexpr int kBins = 60;
  std::vector<int> counts(kBins, 0);
  int beyond = 0;
  for (double value : values) {
    const int bin = static_cast<int>(value / plot.x_max * kBins);
    beyond += bin >= kBins;
    ++counts[static_cast<size_t>(std::clamp(bin, 0, kBins - 1))];
  }
  const int tallest = *std::ranges::max_element(counts);
  std::string svg = absl::StrCat(
      OpenSvg(plot, absl::StrCat("Histogram in ", unit)), XAxis(plot, unit));
  const double bin_width = plot.inner_width() / kBins;
  for (int bin = 0; bin < kBins; ++bin) {
    const int count = counts[static_cast<size_t>(bin)];
    if (count == 0) continue;
    // The marks' words keep the top fifth.
    const double tall = 0.8 * plot.inner_height() * count / tallest;
    absl::StrAppendFormat(
        &svg,
        "<rect x=\"%.2f\" y=\"%.1f\" width=\"%.2f\" height=\"%.1f\" "
        "class=\"bar\"><title>%.2f to %.2f %s: %d frames</title></rect>\n",
        plot.left + bin * bin_width + 0.6, plot.base() - tall, bin_width - 1.2,
        tall, bin * plot.x_max / kBins, (bin + 1) * plot.x_max / kBins, unit,
        count);
  }
  absl::StrAppend(&svg, VerticalMarks(plot, marks));
  if (beyond > 0) {
    absl::StrAppend(&svg,
                    SvgText(plot.width - plot.right, plot.base() - 26, "end",
                            "marklabel", absl::StrCat(beyond, " beyond")));
  }
  return svg + "</svg>\n";
}

std::string ErrorChart(const std::vector<ErrorPoint>& points,
                       absl::string_view x_label, absl::string_view y_unit,
                       bool x_is_integer, const std::vector<ChartMark>& marks) {
  double x_max = x_is_integer ? 1 : 1e-3;
  for (const ErrorPoint& point : points) x_max = std::max(x_max, point.x);
  const Plot plot{.width = 1100, .left = 62, .x_max = x_max * 1.01};
  const LogAxis axis = LogAxisFor(points, marks);
  std::string svg =
      absl::StrCat(OpenSvg(plot, absl::StrCat("Error by ", x_label)),
                   LogGrid(plot, axis, y_unit), XAxis(plot, x_label));
  for (const ChartMark& mark : marks) {
    const double y = plot.Y(axis.Fraction(mark.value));
    absl::StrAppend(&svg,
                    SvgLine(plot.left, y, plot.width - plot.right, y, "mark"),
                    SvgText(plot.width - plot.right, y - 5, "end", "marklabel",
                            mark.label));
  }
  for (const ErrorPoint& point : points) {
    absl::StrAppend(&svg, ErrorDot(plot, axis, point));
  }
  return svg + "</svg>\n";
}

}  // namespace treeline::report

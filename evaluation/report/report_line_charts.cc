#include "evaluation/report/report_line_charts.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/report/report_svg.h"

namespace treeline::report {
namespace {

constexpr size_t kSeriesColors = 8;
// A curve of many values is drawn through so many of them.
constexpr size_t kCurveSteps = 200;

// Lines at round values from `low` to `high`, with their numbers.
std::string ValueGrid(const Plot& plot, double low, double high,
                      absl::string_view label) {
  std::string svg;
  const std::vector<double> ticks = RoundTicks(high - low, 5);
  const double step = ticks.size() > 1 ? ticks[1] : high - low;
  for (double tick = std::ceil(low / step - 1e-9) * step;
       tick <= high + 1e-9 * step; tick += step) {
    const double y = plot.Y((tick - low) / (high - low));
    absl::StrAppend(
        &svg, SvgLine(plot.left, y, plot.width - plot.right, y, "grid"),
        SvgText(plot.left - 8, y + 4, "end", "tick",
                absl::StrFormat("%g", std::abs(tick) < 1e-12 ? 0 : tick)));
  }
  return svg + SvgText(4, 14, "start", "label", label);
}

// Where LineChart's vertical axis begins and ends.
struct Range {
  double low = 0;
  double high = 1;
};

Range RangeOf(const std::vector<LineSeries>& series, double y_limit) {
  double low = 1e300;
  double high = -1e300;
  for (const LineSeries& line : series) {
    for (const LinePoint& point : line.points) {
      low = std::min(low, point.y);
      high = std::max(high, point.y);
    }
  }
  if (low > high) return {};
  const double spread = std::max(high - low, 0.05 * std::abs(high));
  Range range{low - 0.15 * spread, std::min(high + 0.1 * spread, y_limit)};
  // Zero belongs into the picture unless it would flatten it.
  if (low >= 0 && low < 3 * spread) range.low = 0;
  if (range.high <= range.low) range.high = range.low + 1;
  return range;
}

std::string ValuesPath(const Plot& plot, const CurveValues& curve) {
  const auto total = static_cast<double>(std::max<int64_t>(curve.total, 1));
  std::string path = absl::StrFormat("M%.1f %.1f", plot.X(0), plot.Y(0));
  const auto end =
      std::ranges::upper_bound(curve.values, plot.x_max) - curve.values.begin();
  const auto count = static_cast<size_t>(end);
  const size_t stride = std::max<size_t>(1, count / kCurveSteps);
  for (size_t i = stride - 1; i < count; i += stride) {
    // Few values make steps, many a line.
    const double x = plot.X(curve.values[i]);
    const double y = plot.Y(static_cast<double>(i + 1) / total);
    if (stride == 1) {
      absl::StrAppendFormat(&path, "H%.1fV%.1f", x, y);
    } else {
      absl::StrAppendFormat(&path, "L%.1f %.1f", x, y);
    }
  }
  absl::StrAppendFormat(&path, "L%.1f %.1f", plot.X(plot.x_max),
                        plot.Y(static_cast<double>(count) / total));
  return path;
}

}  // namespace

std::string SeriesClass(size_t i) {
  return absl::StrCat("s", i % kSeriesColors,
                      i >= kSeriesColors ? " dashed" : "");
}

std::string SeriesLegend(const std::vector<std::string>& names) {
  std::string html = "<ul class=\"legend\">";
  for (size_t i = 0; i < names.size(); ++i) {
    absl::StrAppend(&html, "<li><i class=\"line ", SeriesClass(i), "\"></i>",
                    EscapeHtml(names[i]), "</li>");
  }
  return html + "</ul>\n";
}

std::string CumulativeCurves(std::vector<CurveValues> curves, double x_max,
                             absl::string_view unit,
                             const std::vector<ChartMark>& marks) {
  const Plot plot{.x_max = x_max};
  std::string svg =
      absl::StrCat(OpenSvg(plot, absl::StrCat("Cumulative error in ", unit)),
                   PercentGrid(plot), XAxis(plot, unit));
  for (const ChartMark& mark : marks) {
    const double x = plot.X(mark.value);
    absl::StrAppend(
        &svg, SvgLine(x, plot.top, x, plot.base(), "mark"),
        SvgText(x + 5, plot.base() - 8, "start", "marklabel", mark.label));
  }
  // The first method on top.
  for (size_t i = curves.size(); i-- > 0;) {
    std::ranges::sort(curves[i].values);
    absl::StrAppendFormat(
        &svg, "<path d=\"%s\" class=\"series %s\"><title>%s</title></path>\n",
        ValuesPath(plot, curves[i]), SeriesClass(i),
        EscapeHtml(curves[i].name));
  }
  return svg + "</svg>\n";
}

std::string LineChart(const std::vector<LineSeries>& series,
                      absl::string_view x_label, absl::string_view y_label,
                      double y_limit) {
  double x_max = 1e-9;
  for (const LineSeries& line : series) {
    for (const LinePoint& point : line.points) {
      x_max = std::max(x_max, point.x);
    }
  }
  const Plot plot{.top = 40, .x_max = x_max * 1.02};
  const Range range = RangeOf(series, y_limit);
  const auto y_of = [&](double y) {
    return plot.Y((y - range.low) / (range.high - range.low));
  };
  std::string svg = absl::StrCat(
      OpenSvg(plot, absl::StrCat(y_label, " by ", x_label)),
      ValueGrid(plot, range.low, range.high, y_label), XAxis(plot, x_label));
  for (size_t i = series.size(); i-- > 0;) {
    std::string path;
    std::string knots;
    for (const LinePoint& point : series[i].points) {
      const double x = plot.X(point.x);
      const double y = y_of(point.y);
      absl::StrAppendFormat(&path, "%s%.1f %.1f", path.empty() ? "M" : "L", x,
                            y);
      absl::StrAppendFormat(
          &knots,
          "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.2\" class=\"seriesknot %s\">"
          "<title>%s</title></circle>\n",
          x, y, SeriesClass(i), EscapeHtml(point.tooltip));
    }
    absl::StrAppendFormat(&svg, "<path d=\"%s\" class=\"series %s\"/>\n%s",
                          path, SeriesClass(i), knots);
  }
  return svg + "</svg>\n";
}

std::string ReliabilityChart(const accuracy::ConfidenceReport& report) {
  if (!report.stated) return "";
  const Plot plot{.x_max = 1};
  std::string svg =
      absl::StrCat(OpenSvg(plot, "Reliability of the stated confidence"),
                   PercentGrid(plot), XAxis(plot, "stated confidence"));
  for (const accuracy::ReliabilityBin& bin : report.bins) {
    if (bin.frames == 0) continue;
    const double left = plot.X(bin.low) + 2;
    const double width = plot.X(bin.high) - 2 - left;
    // A sliver shows a bin none of whose frames is correct.
    const double tall = std::max(plot.inner_height() * bin.correct, 1.5);
    absl::StrAppendFormat(
        &svg,
        "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" "
        "class=\"bar\" fill-opacity=\"0.8\"><title>stated %.0f %%, correct "
        "%.0f %% of %d frames</title></rect>\n",
        left, plot.base() - tall, width, tall, 100 * bin.confidence,
        100 * bin.correct, bin.frames);
    absl::StrAppend(&svg,
                    SvgText(left + width / 2, plot.base() - tall - 5, "middle",
                            "marklabel", absl::StrCat(bin.frames)));
  }
  absl::StrAppend(&svg,
                  SvgLine(plot.X(0), plot.Y(0), plot.X(1), plot.Y(1), "mark"));
  const double at = plot.X(report.threshold);
  return absl::StrCat(svg, SvgLine(at, plot.top, at, plot.base(), "mark"),
                      "</svg>\n");
}

std::string SplitRatioMap(const std::vector<accuracy::LevelSplits>& levels) {
  if (levels.empty()) return "";
  const Plot plot{.x_max = static_cast<double>(levels.size())};
  std::string svg = absl::StrCat(OpenSvg(plot, "Split ratio by level"),
                                 PercentGrid(plot), XAxis(plot, "level"));
  for (size_t level = 0; level < levels.size(); ++level) {
    const accuracy::LevelSplits& at = levels[level];
    int64_t most = 1;
    for (int64_t count : at.by_left_share) most = std::max(most, count);
    for (size_t bin = 0; bin < accuracy::kSplitRatioBins; ++bin) {
      const int64_t count = at.by_left_share[bin];
      if (count == 0) continue;
      const double x = plot.X(static_cast<double>(level));
      absl::StrAppendFormat(
          &svg,
          "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" "
          "class=\"bar\" fill-opacity=\"%.2f\"><title>level %d: %.1f %% of %d "
          "splits send %d to %d %% to the left</title></rect>\n",
          x + 0.5,
          plot.Y((static_cast<double>(bin) + 1) / accuracy::kSplitRatioBins),
          plot.X(static_cast<double>(level) + 1) - x - 1,
          plot.inner_height() / accuracy::kSplitRatioBins - 0.5,
          std::max(static_cast<double>(count) / static_cast<double>(most),
                   0.03),
          level,
          100.0 * static_cast<double>(count) / static_cast<double>(at.splits),
          at.splits, 100 * bin / accuracy::kSplitRatioBins,
          100 * (bin + 1) / accuracy::kSplitRatioBins);
    }
  }
  return svg + "</svg>\n";
}

}  // namespace treeline::report

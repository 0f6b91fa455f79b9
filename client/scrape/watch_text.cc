#include "client/scrape/watch_text.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline::scrape {
namespace {

constexpr const char* kBlocks[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr int kMinColumns = 40;
constexpr int kNameColumns = 12;
constexpr int kBarColumns = 20;

// What a server says of itself must not steer the terminal.
std::string Plain(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; },
      '?');
  return text;
}

std::string Milliseconds(double ms) {
  return std::isnan(ms) ? "-" : absl::StrFormat("%.1f ms", ms);
}

std::string Percent(double share) {
  return std::isnan(share) ? "-" : absl::StrFormat("%.0f %%", 100 * share);
}

std::string Duration(double s) {
  const auto seconds = static_cast<int64_t>(s);
  if (seconds < 120) return absl::StrCat(seconds, " s");
  if (seconds < 7200) return absl::StrCat(seconds / 60, " min");
  return absl::StrFormat("%d h %d min", seconds / 3600, seconds / 60 % 60);
}

// "[#####     ] 5 of 10".
std::string Bar(double value, double of) {
  const double ratio = value / of;
  const double share = std::isfinite(ratio) ? std::clamp(ratio, 0.0, 1.0) : 0.0;
  const auto full = static_cast<size_t>(std::lround(share * kBarColumns));
  return absl::StrFormat("[%s%s] %.0f of %.0f", std::string(full, '#'),
                         std::string(kBarColumns - full, ' '), value, of);
}

std::string Row(const char* name, const std::string& value) {
  return absl::StrFormat("  %-*s %s\n", kNameColumns, name, value);
}

template <typename Of>
std::string CourseRow(const char* name,
                      const std::deque<ServerFigures>& history, int columns,
                      Of of) {
  std::deque<double> values;
  for (const ServerFigures& figures : history) values.push_back(of(figures));
  return Row(name, Sparkline(values, columns - kNameColumns - 4));
}

}  // namespace

std::string Sparkline(const std::deque<double>& values, int width) {
  const size_t shown = std::min(values.size(), static_cast<size_t>(width));
  double largest = 0;
  for (size_t i = values.size() - shown; i < values.size(); ++i) {
    if (values[i] > largest) largest = values[i];
  }
  std::string line;
  for (size_t i = values.size() - shown; i < values.size(); ++i) {
    const double value = values[i];
    // Whatever is not nothing shows.
    const double share = value >= largest      ? 1
                         : std::isinf(largest) ? 0
                                               : value / largest;
    line += value > 0 ? kBlocks[std::max(1L, std::lround(8 * share))] : " ";
  }
  return line;
}

std::string WatchScreen(const std::string& server,
                        const std::deque<ServerFigures>& history, int columns) {
  const ServerFigures& now = history.back();
  columns = std::max(columns, kMinColumns);
  std::string text =
      absl::StrFormat("%s   treeline-server %s, up %s\n\n", server,
                      Plain(now.version), Duration(now.up_s));
  text +=
      Row("answers", absl::StrFormat("%.1f/s, localized %s", now.answers_per_s,
                                     Percent(now.localized_share)));
  text += Row("refused", absl::StrFormat("%.1f/s shed, %.1f/s failed",
                                         now.shed_per_s, now.failed_per_s));
  text += Row("latency", absl::StrCat("p50 ", Milliseconds(now.p50_ms),
                                      ", p99 ", Milliseconds(now.p99_ms)));
  for (const char* stage : {"queue", "decode", "sample", "forest", "pose"}) {
    const auto found = now.stage_ms.find(stage);
    if (found == now.stage_ms.end()) continue;
    text += Row(absl::StrCat("  ", stage).c_str(),
                absl::StrCat("mean ", Milliseconds(found->second)));
  }
  text += Row("workers", Bar(now.in_flight, now.workers));
  text += Row("queue", Bar(now.queue_depth, now.queue_capacity));
  text += Row("processors", absl::StrFormat("%.2f", now.processors));
  text += Row("memory", absl::StrFormat("%.0f MB", 1e-6 * now.resident_bytes));
  std::string scenes;
  for (const auto& [state, count] : now.scenes) {
    absl::StrAppendFormat(&scenes, "%s%.0f %s", scenes.empty() ? "" : ", ",
                          count, Plain(state));
  }
  text += Row("scenes", scenes);
  for (const auto& [scene, rate] : now.answers_per_s_by_scene) {
    text += Row("", absl::StrFormat("%s %.1f/s", Plain(scene), rate));
  }
  text += "\n";
  text += CourseRow("answers/s", history, columns,
                    [](const ServerFigures& f) { return f.answers_per_s; });
  text += CourseRow("p99", history, columns,
                    [](const ServerFigures& f) { return f.p99_ms; });
  text += CourseRow("shed/s", history, columns,
                    [](const ServerFigures& f) { return f.shed_per_s; });
  return text;
}

std::string WatchLine(const ServerFigures& figures) {
  return absl::StrFormat(
      "%.1f/s answered, localized %s, %.1f/s shed, %.1f/s failed, p50 %s, p99 "
      "%s, queue %.0f of %.0f, %.2f processors, %.0f MB",
      figures.answers_per_s, Percent(figures.localized_share),
      figures.shed_per_s, figures.failed_per_s, Milliseconds(figures.p50_ms),
      Milliseconds(figures.p99_ms), figures.queue_depth, figures.queue_capacity,
      figures.processors, 1e-6 * figures.resident_bytes);
}

}  // namespace treeline::scrape

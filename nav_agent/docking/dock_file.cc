#include "nav_agent/docking/dock_file.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/checked_lines.h"
#include "common/base/status_macros.h"

namespace treeline::docking {
namespace {

constexpr char kFirstLine[] = "treeline-docks 2";
constexpr char kFirstLineOfOld[] = "treeline-docks 1";
constexpr char kWhat[] = "a file of docks";
constexpr absl::string_view kSeen = "seen ";
constexpr char kForward[] = "forward";
constexpr char kBackward[] = "backward";

absl::StatusOr<Dock> ReadDock(absl::string_view line) {
  base::LineWords words(line);
  if (words.Next() != "dock") {
    return absl::InvalidArgumentError("is no 'dock'");
  }
  Dock dock;
  geometry::Rigid2& docked = dock.map_from_docked;
  if (!words.Number(dock.level) || !words.Number(docked.translation.x) ||
      !words.Number(docked.translation.y) || !words.Number(docked.yaw_rad)) {
    return absl::InvalidArgumentError("a number is missing, or is none");
  }
  const absl::string_view end = words.Next();
  if (end != kForward && end != kBackward) {
    return absl::InvalidArgumentError("is neither 'forward' nor 'backward'");
  }
  dock.is_backward = end == kBackward;
  if (!words.Number(dock.staging_m)) {
    return absl::InvalidArgumentError("a number is missing, or is none");
  }
  dock.name = std::string(words.rest());
  return dock;
}

absl::StatusOr<std::vector<geometry::Vec2>> ReadView(absl::string_view line) {
  std::vector<geometry::Vec2> view;
  base::LineWords words(line.substr(kSeen.size()));
  while (!words.rest().empty()) {
    int x_mm = 0;
    int y_mm = 0;
    if (view.size() >= kMaxViewPoints || !words.Number(x_mm) ||
        !words.Number(y_mm)) {
      return absl::InvalidArgumentError(
          "a number is missing, or is none, or there are too many");
    }
    view.push_back({1e-3 * x_mm, 1e-3 * y_mm});
  }
  return view;
}

absl::Status ReadLine(absl::string_view line, std::vector<Dock>& docks) {
  if (!absl::StartsWith(line, kSeen)) {
    TL_ASSIGN_OR_RETURN(Dock dock, ReadDock(line));
    docks.push_back(std::move(dock));
    return absl::OkStatus();
  }
  if (docks.empty() || !docks.back().view.empty()) {
    return absl::InvalidArgumentError("is of no dock");
  }
  TL_ASSIGN_OR_RETURN(docks.back().view, ReadView(line));
  return absl::OkStatus();
}

}  // namespace

std::string DockFileText(std::span<const Dock> docks) {
  std::vector<std::string> lines;
  for (const Dock& dock : docks) {
    const geometry::Rigid2& docked = dock.map_from_docked;
    lines.push_back(absl::StrFormat(
        "dock %d %.17g %.17g %.17g %s %.17g %s", dock.level,
        docked.translation.x, docked.translation.y, docked.yaw_rad,
        dock.is_backward ? kBackward : kForward, dock.staging_m, dock.name));
    if (dock.view.empty()) continue;
    std::string seen = "seen";
    for (const geometry::Vec2& point : dock.view) {
      absl::StrAppend(&seen, " ", std::lround(1e3 * point.x), " ",
                      std::lround(1e3 * point.y));
    }
    lines.push_back(std::move(seen));
  }
  return base::CheckedLinesText(kFirstLine, lines);
}

absl::StatusOr<std::vector<Dock>> ParseDockFile(absl::string_view text) {
  const bool is_old = absl::StartsWith(text, kFirstLineOfOld);
  TL_ASSIGN_OR_RETURN(const std::vector<absl::string_view> lines,
                      base::ParseCheckedLines(
                          is_old ? kFirstLineOfOld : kFirstLine, kWhat, text));
  std::vector<Dock> docks;
  for (size_t i = 0; i < lines.size(); ++i) {
    const absl::Status read = ReadLine(lines[i], docks);
    if (!read.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", i + 2, ": ", read.message()));
    }
  }
  return docks;
}

}  // namespace treeline::docking

#include "nav_agent/docking/dock_file.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/checked_lines.h"

namespace treeline::docking {
namespace {

constexpr char kFirstLine[] = "treeline-docks 1";
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

}  // namespace

std::string DockFileText(std::span<const Dock> docks) {
  std::vector<std::string> lines;
  for (const Dock& dock : docks) {
    const geometry::Rigid2& docked = dock.map_from_docked;
    lines.push_back(absl::StrFormat(
        "dock %d %.17g %.17g %.17g %s %.17g %s", dock.level,
        docked.translation.x, docked.translation.y, docked.yaw_rad,
        dock.is_backward ? kBackward : kForward, dock.staging_m, dock.name));
  }
  return base::CheckedLinesText(kFirstLine, lines);
}

absl::StatusOr<std::vector<Dock>> ParseDockFile(absl::string_view text) {
  return base::ParseCheckedThings<Dock>(kFirstLine, "a file of docks", text,
                                        ReadDock);
}

}  // namespace treeline::docking

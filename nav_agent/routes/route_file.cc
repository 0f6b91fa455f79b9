#include "nav_agent/routes/route_file.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/checked_lines.h"
#include "common/base/status_macros.h"

namespace treeline::routes {
namespace {

constexpr char kRoutesLine[] = "treeline-routes 1";
constexpr char kProgressLine[] = "treeline-route-progress 1";
constexpr char kNoYaw[] = "-";
constexpr int kLastCause = static_cast<int>(core::NavigationCause::kZone);

std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char letter) { return static_cast<unsigned char>(letter) < ' '; },
      ' ');
  return text;
}

absl::Status NoNumber() {
  return absl::InvalidArgumentError("a number is missing, or is none");
}

void AppendRoute(const Route& route, std::vector<std::string>& lines) {
  lines.push_back(absl::StrCat(
      "route ", route.waypoints.size(), " ", route.is_loop ? "loop" : "once",
      " ", MissedPolicyName(route.when_missed), " ", route.name));
  for (const Waypoint& waypoint : route.waypoints) {
    lines.push_back(
        absl::StrFormat("waypoint %d %.17g %.17g %s %.17g %s", waypoint.level,
                        waypoint.position_in_map.x, waypoint.position_in_map.y,
                        waypoint.yaw_rad.has_value()
                            ? absl::StrFormat("%.17g", *waypoint.yaw_rad)
                            : std::string(kNoYaw),
                        waypoint.wait_s, waypoint.name));
  }
}

// Lines that are taken one after the other, of a given kind each.
class LineReader {
 public:
  explicit LineReader(std::vector<absl::string_view> lines)
      : lines_(std::move(lines)) {}

  bool IsAtEnd() const { return next_ == lines_.size(); }
  bool IsNext(absl::string_view kind) const {
    return !IsAtEnd() && base::LineWords(lines_[next_]).Next() == kind;
  }
  // What follows the line's kind. INVALID_ARGUMENT: it is of another.
  absl::StatusOr<base::LineWords> Take(absl::string_view kind) {
    if (!IsNext(kind)) {
      return absl::InvalidArgumentError(absl::StrCat("is no '", kind, "'"));
    }
    base::LineWords words(lines_[next_++]);
    words.Next();
    return words;
  }
  // With the line that was taken last, or that is next: of the text, from 1.
  absl::Status Annotate(const absl::Status& status) const {
    return absl::InvalidArgumentError(absl::StrCat(
        "line ", std::min(next_, lines_.size()) + 1, ": ", status.message()));
  }

 private:
  std::vector<absl::string_view> lines_;
  size_t next_ = 0;
};

absl::StatusOr<Waypoint> ReadWaypoint(LineReader& lines) {
  TL_ASSIGN_OR_RETURN(base::LineWords words, lines.Take("waypoint"));
  Waypoint waypoint;
  if (!words.Number(waypoint.level) ||
      !words.Number(waypoint.position_in_map.x) ||
      !words.Number(waypoint.position_in_map.y)) {
    return NoNumber();
  }
  const base::LineWords before_yaw = words;
  if (words.Next() != kNoYaw) {
    words = before_yaw;
    double yaw_rad = 0;
    if (!words.Number(yaw_rad)) return NoNumber();
    waypoint.yaw_rad = yaw_rad;
  }
  if (!words.Number(waypoint.wait_s)) return NoNumber();
  waypoint.name = std::string(words.rest());
  return waypoint;
}

absl::StatusOr<Route> ReadRoute(LineReader& lines) {
  TL_ASSIGN_OR_RETURN(base::LineWords words, lines.Take("route"));
  Route route;
  size_t waypoints = 0;
  if (!words.Number(waypoints) || waypoints > kMaxWaypoints) return NoNumber();
  const absl::string_view laps = words.Next();
  if (laps != "once" && laps != "loop") {
    return absl::InvalidArgumentError("is neither 'once' nor 'loop'");
  }
  route.is_loop = laps == "loop";
  TL_ASSIGN_OR_RETURN(route.when_missed, ParseMissedPolicy(words.Next()));
  route.name = std::string(words.rest());
  for (size_t i = 0; i < waypoints; ++i) {
    TL_ASSIGN_OR_RETURN(Waypoint waypoint, ReadWaypoint(lines));
    route.waypoints.push_back(std::move(waypoint));
  }
  return route;
}

absl::StatusOr<MissedWaypoint> ReadMissed(LineReader& lines) {
  TL_ASSIGN_OR_RETURN(base::LineWords words, lines.Take("missed"));
  MissedWaypoint missed;
  int cause = 0;
  if (!words.Number(missed.waypoint) || !words.Number(missed.lap) ||
      !words.Number(cause) || cause < 0 || cause > kLastCause) {
    return NoNumber();
  }
  missed.cause = static_cast<core::NavigationCause>(cause);
  missed.why = std::string(words.rest());
  return missed;
}

absl::StatusOr<RouteProgress> ReadProgress(LineReader& lines) {
  TL_ASSIGN_OR_RETURN(base::LineWords words, lines.Take("progress"));
  RouteProgress progress;
  if (!words.Number(progress.waypoint) || !words.Number(progress.lap) ||
      !words.Number(progress.reached) || !words.Number(progress.missed) ||
      progress.lap < 0 || progress.reached < 0 || progress.missed < 0) {
    return NoNumber();
  }
  while (lines.IsNext("missed")) {
    TL_ASSIGN_OR_RETURN(MissedWaypoint missed, ReadMissed(lines));
    progress.last_missed.push_back(std::move(missed));
  }
  TL_ASSIGN_OR_RETURN(Route route, ReadRoute(lines));
  if (progress.waypoint >= route.waypoints.size() ||
      progress.last_missed.size() > kListedMissed ||
      std::ranges::any_of(progress.last_missed,
                          [&](const MissedWaypoint& missed) {
                            return missed.waypoint >= route.waypoints.size();
                          })) {
    return absl::InvalidArgumentError("its progress is not that of the route");
  }
  progress.route = std::make_shared<const Route>(std::move(route));
  return progress;
}

}  // namespace

std::string RouteFileText(std::span<const Route> routes) {
  std::vector<std::string> lines;
  for (const Route& route : routes) AppendRoute(route, lines);
  return base::CheckedLinesText(kRoutesLine, lines);
}

absl::StatusOr<std::vector<Route>> ParseRouteFile(absl::string_view text) {
  TL_ASSIGN_OR_RETURN(
      std::vector<absl::string_view> found,
      base::ParseCheckedLines(kRoutesLine, "a file of routes", text));
  LineReader lines(std::move(found));
  std::vector<Route> routes;
  while (!lines.IsAtEnd()) {
    absl::StatusOr<Route> route = ReadRoute(lines);
    if (!route.ok()) return lines.Annotate(route.status());
    routes.push_back(*std::move(route));
  }
  return routes;
}

std::string ProgressFileText(const std::optional<RouteProgress>& progress) {
  std::vector<std::string> lines;
  if (progress.has_value()) {
    lines.push_back(absl::StrCat("progress ", progress->waypoint, " ",
                                 progress->lap, " ", progress->reached, " ",
                                 progress->missed));
    for (const MissedWaypoint& missed : progress->last_missed) {
      lines.push_back(absl::StrCat("missed ", missed.waypoint, " ", missed.lap,
                                   " ", static_cast<int>(missed.cause), " ",
                                   OneLine(missed.why)));
    }
    AppendRoute(*progress->route, lines);
  }
  return base::CheckedLinesText(kProgressLine, lines);
}

absl::StatusOr<std::optional<RouteProgress>> ParseProgressFile(
    absl::string_view text) {
  TL_ASSIGN_OR_RETURN(
      std::vector<absl::string_view> found,
      base::ParseCheckedLines(kProgressLine, "a route's progress", text));
  LineReader lines(std::move(found));
  if (lines.IsAtEnd()) return std::nullopt;
  absl::StatusOr<RouteProgress> progress = ReadProgress(lines);
  if (!progress.ok()) return lines.Annotate(progress.status());
  if (!lines.IsAtEnd()) {
    return absl::InvalidArgumentError("something follows the route");
  }
  return std::optional<RouteProgress>(*std::move(progress));
}

}  // namespace treeline::routes

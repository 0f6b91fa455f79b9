#include "nav_agent/zones/zone_file.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/checked_lines.h"
#include "common/base/status_macros.h"

namespace treeline::zones {
namespace {

constexpr char kFirstLine[] = "treeline-zones 1";

absl::StatusOr<Zone> ParseLine(absl::string_view line) {
  base::LineWords words(line);
  Zone zone;
  TL_ASSIGN_OR_RETURN(zone.kind, ParseZoneKind(words.Next()));
  int corners = 0;
  if (!words.Number(zone.level) || !words.Number(zone.max_mps) ||
      !words.Number(zone.direction_rad) || !words.Number(corners) ||
      corners < 0 || static_cast<size_t>(corners) > kMaxZoneCorners) {
    return absl::InvalidArgumentError("a number is missing, or is none");
  }
  for (int i = 0; i < corners; ++i) {
    geometry::Vec2 corner;
    if (!words.Number(corner.x) || !words.Number(corner.y)) {
      return absl::InvalidArgumentError(
          absl::StrCat("corner ", i + 1, " is missing, or is none"));
    }
    zone.corners_in_map.push_back(corner);
  }
  zone.name = std::string(words.rest());
  return zone;
}

}  // namespace

std::string ZoneFileText(std::span<const Zone> zones) {
  std::vector<std::string> lines;
  for (const Zone& zone : zones) {
    std::string line = absl::StrFormat(
        "%s %d %.17g %.17g %d", ZoneKindName(zone.kind), zone.level,
        zone.max_mps, zone.direction_rad, zone.corners_in_map.size());
    for (const geometry::Vec2& corner : zone.corners_in_map) {
      absl::StrAppendFormat(&line, " %.17g %.17g", corner.x, corner.y);
    }
    absl::StrAppend(&line, " ", zone.name);
    lines.push_back(std::move(line));
  }
  return base::CheckedLinesText(kFirstLine, lines);
}

absl::StatusOr<std::vector<Zone>> ParseZoneFile(absl::string_view text) {
  return base::ParseCheckedThings<Zone>(kFirstLine, "a file of zones", text,
                                        ParseLine);
}

}  // namespace treeline::zones

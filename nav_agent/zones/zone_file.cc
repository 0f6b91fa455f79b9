#include "nav_agent/zones/zone_file.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"

namespace treeline::zones {
namespace {

constexpr char kFirstLine[] = "treeline-zones 1\n";

// Fowler, Noll and Vo's hash, variant 1a.
uint64_t Checksum(absl::string_view bytes) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const char byte : bytes) {
    hash ^= static_cast<uint8_t>(byte);
    hash *= 0x100000001b3u;
  }
  return hash;
}

std::string LastLine(size_t zones, absl::string_view before) {
  return absl::StrFormat("end %d %016x\n", zones, Checksum(before));
}

// What is left of a line, word by word.
class Words {
 public:
  explicit Words(absl::string_view line) : rest_(line) {}

  absl::string_view Next() {
    const size_t end = std::min(rest_.find(' '), rest_.size());
    const absl::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return word;
  }
  bool Number(double& value) { return absl::SimpleAtod(Next(), &value); }
  bool Number(int& value) { return absl::SimpleAtoi(Next(), &value); }
  absl::string_view rest() const { return rest_; }

 private:
  absl::string_view rest_;
};

absl::StatusOr<Zone> ParseLine(absl::string_view line) {
  Words words(line);
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
  std::string text = kFirstLine;
  for (const Zone& zone : zones) {
    absl::StrAppendFormat(&text, "%s %d %.17g %.17g %d",
                          ZoneKindName(zone.kind), zone.level, zone.max_mps,
                          zone.direction_rad, zone.corners_in_map.size());
    for (const geometry::Vec2& corner : zone.corners_in_map) {
      absl::StrAppendFormat(&text, " %.17g %.17g", corner.x, corner.y);
    }
    absl::StrAppend(&text, " ", zone.name, "\n");
  }
  return absl::StrCat(text, LastLine(zones.size(), text));
}

absl::StatusOr<std::vector<Zone>> ParseZoneFile(absl::string_view text) {
  const std::vector<absl::string_view> lines = absl::StrSplit(text, '\n');
  // What follows the last end of line is empty.
  if (lines.size() < 3 || absl::StrCat(lines.front(), "\n") != kFirstLine ||
      !lines.back().empty()) {
    return absl::InvalidArgumentError("not a file of zones, or not all of one");
  }
  const absl::string_view last = lines[lines.size() - 2];
  const absl::string_view before =
      text.substr(0, text.size() - last.size() - 1);
  if (absl::StrCat(last, "\n") != LastLine(lines.size() - 3, before)) {
    return absl::InvalidArgumentError(
        "its last line does not fit: it was cut off, or changed");
  }
  std::vector<Zone> zones;
  for (size_t i = 1; i + 2 < lines.size(); ++i) {
    absl::StatusOr<Zone> zone = ParseLine(lines[i]);
    if (!zone.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", i + 1, ": ", zone.status().message()));
    }
    zones.push_back(*std::move(zone));
  }
  return zones;
}

}  // namespace treeline::zones

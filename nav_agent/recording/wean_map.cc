#include "nav_agent/recording/wean_map.h"

#include <cstddef>
#include <cstdint>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "nav_agent/recording/gunzip.h"

namespace treeline::recording {
namespace {

constexpr size_t kMaxMapBytes = size_t{1} << 28;
constexpr absl::string_view kResolution = "robot_specifications->resolution";
constexpr absl::string_view kMap = "global_map[0]:";
constexpr double kFreeAbove = 0.8;
constexpr double kOccupiedBelow = 0.2;

absl::string_view NextLine(absl::string_view& text) {
  const size_t end = text.find('\n');
  const absl::string_view line = text.substr(0, end);
  text.remove_prefix(end == absl::string_view::npos ? text.size() : end + 1);
  return line;
}

absl::string_view NextWord(absl::string_view& text) {
  text = absl::StripLeadingAsciiWhitespace(text);
  size_t length = 0;
  while (length < text.size() &&
         !absl::ascii_isspace(static_cast<unsigned char>(text[length]))) {
    ++length;
  }
  const absl::string_view word = text.substr(0, length);
  text.remove_prefix(length);
  return word;
}

absl::Status Error(const std::string& name, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(name, ": ", what));
}

// What comes before the cells. Leaves `text` at the first of them.
absl::StatusOr<core::OccupancyGrid> ParseHead(absl::string_view& text,
                                              const std::string& name) {
  double resolution_cm = 10;
  while (!text.empty()) {
    absl::string_view line = NextLine(text);
    if (absl::ConsumePrefix(&line, kResolution)) {
      if (!absl::SimpleAtod(NextWord(line), &resolution_cm) ||
          !(resolution_cm >= 0.1) || !(resolution_cm <= 1000)) {
        return Error(name, "its resolution is not 0.1 to 1000 cm");
      }
    } else if (absl::ConsumePrefix(&line, kMap)) {
      int rows = 0;
      int columns = 0;
      if (!absl::SimpleAtoi(NextWord(line), &rows) ||
          !absl::SimpleAtoi(NextWord(line), &columns) || rows < 1 ||
          columns < 1 || rows > 20000 || columns > 20000 ||
          // Each number takes a digit and a space.
          static_cast<size_t>(rows) * static_cast<size_t>(columns) >
              text.size()) {
        return Error(name, "its size is missing, or more than what follows");
      }
      return core::OccupancyGrid::Filled(rows, columns, resolution_cm / 100, {},
                                         core::Occupancy::kUnknown);
    }
  }
  return Error(name, absl::StrCat("there is no line '", kMap, "'"));
}

}  // namespace

absl::StatusOr<core::OccupancyGrid> ParseWeanMap(absl::string_view bytes,
                                                 const std::string& name) {
  if (IsGzip(bytes)) {
    TL_ASSIGN_OR_RETURN(const std::string text, Gunzip(bytes, kMaxMapBytes));
    return ParseWeanMap(text, name);
  }
  absl::string_view rest = bytes;
  TL_ASSIGN_OR_RETURN(core::OccupancyGrid map, ParseHead(rest, name));
  for (int x = 0; x < map.width; ++x) {
    for (int y = 0; y < map.height; ++y) {
      double free = 0;
      if (!absl::SimpleAtod(NextWord(rest), &free) || !(free >= -1) ||
          !(free <= 1)) {
        return Error(name, absl::StrCat("cell ", x, ", ", y,
                                        " is missing or not in -1..1"));
      }
      if (free > kFreeAbove) map.Set({x, y}, core::Occupancy::kFree);
      if (free >= 0 && free < kOccupiedBelow) {
        map.Set({x, y}, core::Occupancy::kOccupied);
      }
    }
  }
  return map;
}

absl::StatusOr<core::OccupancyGrid> ReadWeanMap(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string bytes,
                      base::ReadFile(path, kMaxMapBytes));
  return ParseWeanMap(bytes, path);
}

}  // namespace treeline::recording

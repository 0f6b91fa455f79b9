#include "common/base/checked_lines.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace treeline::base {
namespace {

// Fowler, Noll and Vo's hash, variant 1a.
uint64_t Checksum(absl::string_view bytes) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const char byte : bytes) {
    hash ^= static_cast<uint8_t>(byte);
    hash *= 0x100000001b3u;
  }
  return hash;
}

std::string LastLine(size_t lines, absl::string_view before) {
  return absl::StrFormat("end %d %016x", lines, Checksum(before));
}

}  // namespace

std::string CheckedLinesText(absl::string_view first_line,
                             const std::vector<std::string>& lines) {
  std::string text = absl::StrCat(first_line, "\n");
  for (const std::string& line : lines) absl::StrAppend(&text, line, "\n");
  return absl::StrCat(text, LastLine(lines.size(), text), "\n");
}

absl::StatusOr<std::vector<absl::string_view>> ParseCheckedLines(
    absl::string_view first_line, absl::string_view what,
    absl::string_view text) {
  std::vector<absl::string_view> lines = absl::StrSplit(text, '\n');
  // What follows the last end of line is empty.
  if (lines.size() < 3 || lines.front() != first_line ||
      !lines.back().empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("not ", what, ", or not all of one"));
  }
  const absl::string_view last = lines[lines.size() - 2];
  const absl::string_view before =
      text.substr(0, text.size() - last.size() - 1);
  if (last != LastLine(lines.size() - 3, before)) {
    return absl::InvalidArgumentError(
        "its last line does not fit: it was cut off, or changed");
  }
  lines.resize(lines.size() - 2);
  lines.erase(lines.begin());
  return lines;
}

}  // namespace treeline::base

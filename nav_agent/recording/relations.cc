#include "nav_agent/recording/relations.h"

#include <span>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_lines.h"

namespace treeline::recording {

absl::StatusOr<std::vector<PoseRelation>> ParseRelations(
    absl::string_view text, const std::string& name) {
  std::vector<PoseRelation> relations;
  int line_number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++line_number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty() || line[0] == '#') continue;
    const std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    if (words.size() != 8) {
      return dataset::LineError(
          name, line_number,
          absl::StrCat("8 numbers belong here, not ", words.size()));
    }
    const auto from = ParseRecordingTime(words[0]);
    const auto to = ParseRecordingTime(words[1]);
    if (!from.has_value() || !to.has_value()) {
      return dataset::LineError(name, line_number, "no time stamp in seconds");
    }
    double numbers[6] = {};
    TL_RETURN_IF_ERROR(dataset::ParseNumbers(
        std::span<const absl::string_view>(words).subspan(2), name, line_number,
        numbers));
    relations.push_back(
        {.from = *from,
         .to = *to,
         .from_base_from_to_base = {{numbers[0], numbers[1]}, numbers[5]}});
  }
  if (relations.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": no relations"));
  }
  return relations;
}

absl::StatusOr<std::vector<PoseRelation>> ReadRelations(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path));
  return ParseRelations(text, path);
}

}  // namespace treeline::recording

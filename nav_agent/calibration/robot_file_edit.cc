#include "nav_agent/calibration/robot_file_edit.h"

#include <cctype>
#include <cmath>
#include <optional>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"

namespace treeline::calibration {
namespace {

struct Range {
  size_t begin = 0;
  size_t end = 0;
};

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r'; }

// Positions of `text` in comments and quotes, which hold no keys.
std::vector<bool> Hidden(const std::string& text) {
  std::vector<bool> hidden(text.size(), false);
  char quote = 0;
  bool is_comment = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      is_comment = false;
      quote = 0;
    } else if (!is_comment && quote == 0 && c == '#' &&
               (i == 0 || IsSpace(text[i - 1]) || text[i - 1] == '\n')) {
      is_comment = true;
    } else if (!is_comment && (c == '"' || c == '\'')) {
      quote = quote == 0 ? c : (quote == c ? 0 : quote);
    }
    hidden[i] = is_comment || quote != 0;
  }
  return hidden;
}

// Where `key:` stands in `range`: the place behind the colon. At top level it
// begins a line.
std::optional<size_t> FindKey(const std::string& text, const Range& range,
                              const std::string& key, bool is_top) {
  const std::vector<bool> hidden = Hidden(text);
  const std::string wanted = key + ":";
  for (size_t i = range.begin; i + wanted.size() <= range.end; ++i) {
    if (hidden[i] || text.compare(i, wanted.size(), wanted) != 0) continue;
    const char before = i == 0 ? '\n' : text[i - 1];
    const bool begins = is_top ? before == '\n'
                               : before == '\n' || IsSpace(before) ||
                                     before == '{' || before == ',';
    const size_t after = i + wanted.size();
    const bool ends =
        after == text.size() || IsSpace(text[after]) || text[after] == '\n';
    if (begins && ends) return after;
  }
  return std::nullopt;
}

// The value behind a colon: a list in brackets, or up to what ends a scalar.
Range ValueAt(const std::string& text, size_t begin) {
  while (begin < text.size() && IsSpace(text[begin])) ++begin;
  size_t end = begin;
  if (end < text.size() && text[end] == '[') {
    while (end < text.size() && text[end] != ']') ++end;
    return {begin, std::min(end + 1, text.size())};
  }
  while (end < text.size() && text[end] != '\n' && text[end] != ',' &&
         text[end] != '}' &&
         !(text[end] == '#' && end > begin && IsSpace(text[end - 1]))) {
    ++end;
  }
  while (end > begin && IsSpace(text[end - 1])) --end;
  return {begin, end};
}

// A section's text: from behind its colon to the next line that begins at the
// margin.
Range SectionAt(const std::string& text, size_t begin) {
  size_t end = begin;
  while (end < text.size()) {
    if (text[end] == '\n' && end + 1 < text.size() && !IsSpace(text[end + 1]) &&
        text[end + 1] != '\n' && text[end + 1] != '#' && text[end + 1] != '}') {
      return {begin, end + 1};
    }
    ++end;
  }
  return {begin, end};
}

void AppendLine(const std::string& line, std::string& text) {
  if (!text.empty() && text.back() != '\n') text += '\n';
  absl::StrAppend(&text, line, "\n");
}

void SetTop(const FileEntry& entry, std::string& text) {
  const auto key = FindKey(text, {0, text.size()}, entry.key, true);
  if (!key) {
    AppendLine(absl::StrCat(entry.key, ": ", entry.value), text);
    return;
  }
  const Range value = ValueAt(text, *key);
  const bool needs_space = value.begin == *key;
  text.replace(value.begin, value.end - value.begin,
               (needs_space ? " " : "") + entry.value);
}

// The indentation of the first line in the section that has a key.
std::string IndentOf(const std::string& text, const Range& section) {
  for (size_t i = section.begin; i < section.end; ++i) {
    if (text[i] != '\n') continue;
    size_t end = i + 1;
    while (end < section.end && text[end] == ' ') ++end;
    if (end > i + 1 && end < section.end && text[end] != '\n' &&
        text[end] != '#') {
      return text.substr(i + 1, end - i - 1);
    }
  }
  return "  ";
}

void SetInSection(const FileEntry& entry, std::string& text) {
  const auto found = FindKey(text, {0, text.size()}, entry.section, true);
  if (!found) {
    AppendLine(absl::StrCat(entry.section, ":"), text);
    AppendLine(absl::StrCat("  ", entry.key, ": ", entry.value), text);
    return;
  }
  const Range section = SectionAt(text, *found);
  if (const auto key = FindKey(text, section, entry.key, false)) {
    const Range value = ValueAt(text, *key);
    text.replace(value.begin, value.end - value.begin, entry.value);
    return;
  }
  const Range value = ValueAt(text, *found);
  if (value.begin < text.size() && text[value.begin] == '{') {
    size_t next = value.begin + 1;
    while (next < text.size() && IsSpace(text[next])) ++next;
    const bool is_empty = next < text.size() && text[next] == '}';
    text.insert(value.begin + 1, absl::StrCat(entry.key, ": ", entry.value,
                                              is_empty ? "" : ", "));
    return;
  }
  const size_t line_end = text.find('\n', *found);
  const std::string line =
      absl::StrCat(IndentOf(text, section), entry.key, ": ", entry.value, "\n");
  if (line_end == std::string::npos) {
    text += "\n" + line;
  } else {
    text.insert(line_end + 1, line);
  }
}

// Whether the file says what it is to say.
absl::Status CheckEntry(const yaml::YamlNode& file, const FileEntry& entry) {
  yaml::YamlNode node = file;
  if (!entry.section.empty()) {
    TL_ASSIGN_OR_RETURN(node, file.Get(entry.section));
  }
  absl::string_view value = entry.value;
  const bool is_list = absl::ConsumePrefix(&value, "[");
  absl::ConsumeSuffix(&value, "]");
  const std::vector<std::string> wanted = absl::StrSplit(value, ", ");
  std::vector<double> got;
  if (is_list) {
    TL_ASSIGN_OR_RETURN(got, node.Numbers(entry.key, wanted.size(), -1e9, 1e9));
  } else {
    TL_ASSIGN_OR_RETURN(const double number, node.Number(entry.key, -1e9, 1e9));
    got = {number};
  }
  for (size_t i = 0; i < wanted.size(); ++i) {
    double number = 0;
    if (!absl::SimpleAtod(wanted[i], &number) || got[i] != number) {
      return absl::InternalError("another value");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> WithEntries(absl::string_view text,
                                        absl::string_view name,
                                        std::span<const FileEntry> entries) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode before,
                      yaml::YamlNode::Parse(text, name));
  if (!before.IsMap()) return before.Error("this is no map of keys");
  std::string edited(text);
  for (const FileEntry& entry : entries) {
    if (entry.section.empty()) {
      SetTop(entry, edited);
    } else {
      SetInSection(entry, edited);
    }
  }
  const auto after = yaml::YamlNode::Parse(edited, name);
  for (const FileEntry& entry : entries) {
    if (!after.ok() || !CheckEntry(*after, entry).ok()) {
      return absl::FailedPreconditionError(absl::StrCat(
          std::string(name),
          ": it is written in a way that is not edited "
          "safely; nothing was changed. Set by hand, ",
          entry.section.empty() ? "at the top"
                                : absl::StrCat("in '", entry.section, "'"),
          ": ", entry.key, ": ", entry.value, ", and the others"));
    }
  }
  return edited;
}

}  // namespace treeline::calibration

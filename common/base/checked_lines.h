// Small files of lines that outlive a program, known to be whole when they are
// read again.
#ifndef COMMON_BASE_CHECKED_LINES_H_
#define COMMON_BASE_CHECKED_LINES_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

// A text of `first_line`, the lines, and a last one with their number and a
// checksum of all before it (FNV-1a, 64 bits):
//
//   FIRST LINE
//   ...
//   end LINES CHECKSUM
//
// No line may have an end of line in it.
std::string CheckedLinesText(absl::string_view first_line,
                             const std::vector<std::string>& lines);

// The lines between the first and the last; views into `text`.
// INVALID_ARGUMENT: its first line is another (`what`: "a file of zones"), or
// it was cut off or changed. Safe on any bytes.
absl::StatusOr<std::vector<absl::string_view>> ParseCheckedLines(
    absl::string_view first_line, absl::string_view what,
    absl::string_view text);

// The same where each line is a thing of its own, which `read` makes of it, or
// says what is wrong with it; the message names the line.
template <typename Thing>
absl::StatusOr<std::vector<Thing>> ParseCheckedThings(
    absl::string_view first_line, absl::string_view what,
    absl::string_view text,
    absl::StatusOr<Thing> (*read)(absl::string_view line)) {
  const absl::StatusOr<std::vector<absl::string_view>> lines =
      ParseCheckedLines(first_line, what, text);
  if (!lines.ok()) return lines.status();
  std::vector<Thing> things;
  for (size_t i = 0; i < lines->size(); ++i) {
    absl::StatusOr<Thing> thing = read((*lines)[i]);
    if (!thing.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", i + 2, ": ", thing.status().message()));
    }
    things.push_back(*std::move(thing));
  }
  return things;
}

// A line, word by word.
class LineWords {
 public:
  explicit LineWords(absl::string_view line) : rest_(line) {}

  // Up to the next space; empty at the end.
  absl::string_view Next() {
    const size_t space = rest_.find(' ');
    const size_t end = space == absl::string_view::npos ? rest_.size() : space;
    const absl::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end < rest_.size() ? end + 1 : end);
    return word;
  }
  // False: the next word is none.
  bool Number(double& value) { return absl::SimpleAtod(Next(), &value); }
  template <typename Integer>
  bool Number(Integer& value) {
    return absl::SimpleAtoi(Next(), &value);
  }
  absl::string_view rest() const { return rest_; }

 private:
  absl::string_view rest_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_CHECKED_LINES_H_

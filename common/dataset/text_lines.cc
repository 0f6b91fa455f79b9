#include "common/dataset/text_lines.h"

#include <cmath>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace treeline::dataset {

absl::Status LineError(const std::string& file, int line,
                       absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(file, ":", line, ": ", what));
}

absl::Status ParseNumbers(std::span<const absl::string_view> words,
                          const std::string& file, int line,
                          std::span<double> numbers) {
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (!absl::SimpleAtod(words[i], &numbers[i]) ||
        !std::isfinite(numbers[i])) {
      return LineError(file, line,
                       absl::StrCat("'", absl::CHexEscape(words[i]),
                                    "' is not a finite number"));
    }
  }
  return absl::OkStatus();
}

bool LeadsOutside(absl::string_view path) {
  if (absl::StartsWith(path, "/")) return true;
  for (absl::string_view part : absl::StrSplit(path, '/')) {
    if (part == "..") return true;
  }
  return false;
}

}  // namespace treeline::dataset

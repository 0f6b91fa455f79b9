// What the readers of text files share.
#ifndef COMMON_DATASET_TEXT_LINES_H_
#define COMMON_DATASET_TEXT_LINES_H_

#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::dataset {

// INVALID_ARGUMENT, "FILE:LINE: what".
absl::Status LineError(const std::string& file, int line,
                       absl::string_view what);

// numbers[i] from words[i], of which there are at least as many. Finite ones
// only; else LineError.
absl::Status ParseNumbers(std::span<const absl::string_view> words,
                          const std::string& file, int line,
                          std::span<double> numbers);

// Whether a relative path is none, or has a part "..".
bool LeadsOutside(absl::string_view path);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_TEXT_LINES_H_

#include "common/base/check_name.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace treeline::base {

absl::Status CheckName(absl::string_view name, absl::string_view whose,
                       size_t max_bytes) {
  if (name.empty() || name.size() > max_bytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        whose, " name has ", name.size(), " bytes; it needs 1 to ", max_bytes));
  }
  const bool is_text = std::none_of(name.begin(), name.end(), [](char letter) {
    const auto byte = static_cast<unsigned char>(letter);
    return byte < ' ' || byte == 0x7f;
  });
  if (!is_text || name.front() == ' ' || name.back() == ' ') {
    return absl::InvalidArgumentError(absl::StrCat(
        whose, " name has control characters, or a space at an end"));
  }
  return absl::OkStatus();
}

}  // namespace treeline::base

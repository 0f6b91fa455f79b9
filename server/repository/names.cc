#include "server/repository/names.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace treeline::repository {
namespace {

// Longer names are not repeated in messages.
constexpr size_t kLongestQuoted = 40;

bool IsNumber(absl::string_view version) {
  return !version.empty() &&
         std::all_of(version.begin(), version.end(), absl::ascii_isdigit);
}

absl::string_view WithoutLeadingZeros(absl::string_view number) {
  return number.substr(std::min(number.find_first_not_of('0'), number.size()));
}

}  // namespace

bool IsValidName(absl::string_view name) {
  return !name.empty() && name.size() <= kLongestName && name[0] != '.' &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  c == '.' || c == '_' || c == '-';
         });
}

absl::Status CheckName(absl::string_view field, absl::string_view name) {
  if (IsValidName(name)) return absl::OkStatus();
  std::string problem;
  if (name.empty()) {
    problem = "is empty";
  } else if (name.size() > kLongestName) {
    problem = absl::StrCat("has ", name.size(), " characters");
  } else {
    problem = absl::StrCat(
        "is '", absl::CHexEscape(name.substr(0, kLongestQuoted)), "'");
  }
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": ", problem, "; a name is 1 to ", kLongestName,
                   " of A-Z a-z 0-9 . _ - and does not start with a dot"));
}

bool VersionIsOlder(absl::string_view a, absl::string_view b) {
  const bool a_is_number = IsNumber(a);
  const bool b_is_number = IsNumber(b);
  if (a_is_number != b_is_number) return a_is_number;
  if (a_is_number) {
    const absl::string_view x = WithoutLeadingZeros(a);
    const absl::string_view y = WithoutLeadingZeros(b);
    if (x.size() != y.size()) return x.size() < y.size();
    if (x != y) return x < y;
  }
  return a < b;
}

}  // namespace treeline::repository

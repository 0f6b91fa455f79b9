// What a misspelt name was probably meant to be.
#ifndef COMMON_BASE_NEAREST_NAME_H_
#define COMMON_BASE_NEAREST_NAME_H_

#include <span>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::base {

// The one of `known` (in snake_case) that is nearest to `unknown`, by letters
// changed, put in or left out; the earliest of several. Dashes, spaces and
// capitals do not count. Empty if none is near.
std::string NearestName(absl::string_view unknown,
                        std::span<const absl::string_view> known);

}  // namespace treeline::base

#endif  // COMMON_BASE_NEAREST_NAME_H_

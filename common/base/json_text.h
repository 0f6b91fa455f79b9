// Text in JSON that is written by hand.
#ifndef COMMON_BASE_JSON_TEXT_H_
#define COMMON_BASE_JSON_TEXT_H_

#include <string>

#include "absl/strings/string_view.h"

namespace treeline::base {

// `text`, of UTF-8, as a JSON string: in quotes, escaped.
std::string JsonQuoted(absl::string_view text);

}  // namespace treeline::base

#endif  // COMMON_BASE_JSON_TEXT_H_

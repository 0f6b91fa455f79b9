// Names that people give to things.
#ifndef COMMON_BASE_CHECK_NAME_H_
#define COMMON_BASE_CHECK_NAME_H_

#include <cstddef>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

// INVALID_ARGUMENT for a name that is empty or longer than max_bytes, has
// control characters, or a space at an end. `whose`: "a zone's".
absl::Status CheckName(absl::string_view name, absl::string_view whose,
                       size_t max_bytes);

}  // namespace treeline::base

#endif  // COMMON_BASE_CHECK_NAME_H_

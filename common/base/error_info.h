// What a program can read from an error, beside its code and its message.
#ifndef COMMON_BASE_ERROR_INFO_H_
#define COMMON_BASE_ERROR_INFO_H_

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

// A stable reason and details, as google.rpc.ErrorInfo carries them; messages
// may change, these do not. docs/reference/service.md lists the reasons.
struct ErrorInfo {
  // UPPER_SNAKE_CASE; empty: none is known.
  std::string reason = {};
  // For instance {"scene", "kitchen"}.
  std::map<std::string, std::string> metadata = {};
};

// `status` with a reason; one that it had already stays, so the innermost one,
// which knows most, wins. OK stays as it is.
absl::Status WithReason(
    absl::Status status, absl::string_view reason,
    const std::map<std::string, std::string>& metadata = {});

// `status` with the time after which trying again may help.
absl::Status WithRetryAfter(absl::Status status,
                            std::chrono::milliseconds retry_after);

ErrorInfo ErrorInfoOf(const absl::Status& status);
std::optional<std::chrono::milliseconds> RetryAfterOf(
    const absl::Status& status);

}  // namespace treeline::base

#endif  // COMMON_BASE_ERROR_INFO_H_

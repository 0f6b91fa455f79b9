#include "common/base/error_info.h"

#include <cstdint>
#include <utility>

#include "absl/strings/cord.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace treeline::base {
namespace {

// Keys of the payloads of an absl::Status.
constexpr char kReasonKey[] = "treeline/reason";
constexpr char kRetryKey[] = "treeline/retry-after-ms";
constexpr char kMetadataPrefix[] = "treeline/metadata/";

}  // namespace

absl::Status WithReason(absl::Status status, absl::string_view reason,
                        const std::map<std::string, std::string>& metadata) {
  if (status.ok() || status.GetPayload(kReasonKey)) return status;
  status.SetPayload(kReasonKey, absl::Cord(reason));
  for (const auto& [key, value] : metadata) {
    status.SetPayload(absl::StrCat(kMetadataPrefix, key), absl::Cord(value));
  }
  return status;
}

absl::Status WithRetryAfter(absl::Status status,
                            std::chrono::milliseconds retry_after) {
  if (status.ok()) return status;
  status.SetPayload(kRetryKey, absl::Cord(absl::StrCat(retry_after.count())));
  return status;
}

ErrorInfo ErrorInfoOf(const absl::Status& status) {
  ErrorInfo info;
  status.ForEachPayload([&](absl::string_view key, const absl::Cord& value) {
    if (key == kReasonKey) {
      info.reason = std::string(value);
    } else if (absl::ConsumePrefix(&key, kMetadataPrefix)) {
      info.metadata[std::string(key)] = std::string(value);
    }
  });
  return info;
}

std::optional<std::chrono::milliseconds> RetryAfterOf(
    const absl::Status& status) {
  const auto payload = status.GetPayload(kRetryKey);
  int64_t milliseconds = 0;
  if (!payload || !absl::SimpleAtoi(std::string(*payload), &milliseconds)) {
    return std::nullopt;
  }
  return std::chrono::milliseconds(milliseconds);
}

}  // namespace treeline::base

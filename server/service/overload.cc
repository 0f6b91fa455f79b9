#include "server/service/overload.h"

#include <string>

#include "common/base/error_info.h"

namespace treeline::service {

absl::Status QueueIsFull(std::chrono::milliseconds retry_after) {
  return base::WithRetryAfter(
      base::WithReason(absl::UnavailableError("overloaded: the queue is full"),
                       "QUEUE_FULL"),
      retry_after);
}

absl::Status InternalFault() {
  return absl::InternalError("a fault of the server; its log has the details");
}

bool IsShed(const absl::Status& status) {
  const std::string reason = base::ErrorInfoOf(status).reason;
  return reason == "QUEUE_FULL" || reason == "DEADLINE_UNREACHABLE" ||
         absl::IsDeadlineExceeded(status);
}

}  // namespace treeline::service

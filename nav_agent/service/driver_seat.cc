#include "nav_agent/service/driver_seat.h"

#include "absl/strings/str_cat.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::agent_service {

absl::Status DriverSeat::Take(const std::string& driver, uint64_t sequence,
                              base::MonotonicTime now) {
  if (driver.empty() || driver.size() > kMaxDriverBytes) {
    return absl::InvalidArgumentError(absl::StrCat("driver has ", driver.size(),
                                                   " bytes; it needs 1 to ",
                                                   kMaxDriverBytes));
  }
  const absl::MutexLock lock(&mutex_);
  if (driver == driver_ && sequence <= sequence_) {
    return absl::AbortedError(
        absl::StrCat("sequence ", sequence, " comes after ", sequence_));
  }
  if (driver != driver_ && last_.has_value() &&
      base::SecondsBetween(*last_, now) < behavior::kManualLease_s) {
    return absl::UnavailableError("somebody else drives by hand");
  }
  driver_ = driver;
  sequence_ = sequence;
  last_ = now;
  return absl::OkStatus();
}

}  // namespace treeline::agent_service

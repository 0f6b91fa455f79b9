#include "common/base/byte_budget.h"

#include <utility>

#include "absl/time/time.h"
#include "common/base/error_info.h"

namespace treeline::base {
namespace {

constexpr uint64_t kSmallShare = 64;
constexpr uint64_t kReservedShare = 4;

}  // namespace

uint64_t ByteBudget::used_bytes() const {
  const absl::MutexLock lock(&mutex_);
  return used_bytes_;
}

bool ByteBudget::HasRoom(uint64_t held, uint64_t wanted) const {
  const uint64_t others = used_bytes_ - held;
  const uint64_t limit = wanted <= total_bytes_ / kSmallShare
                             ? total_bytes_
                             : total_bytes_ - total_bytes_ / kReservedShare;
  return wanted <= held || others == 0 ||
         (others <= limit && wanted <= limit - others);
}

bool ByteBudget::AwaitRoom(uint64_t held, uint64_t wanted,
                           std::chrono::milliseconds patience) {
  const Waiting self{held, -waited_++};
  if (held > 0) waiting_.insert(self);
  waiting_bytes_ += held;
  const auto is_decided = [&]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return HasRoom(held, wanted) || (waiting_bytes_ == used_bytes_ &&
                                     held > 0 && *waiting_.begin() == self);
  };
  mutex_.AwaitWithTimeout(absl::Condition(&is_decided),
                          absl::FromChrono(patience));
  waiting_.erase(self);
  waiting_bytes_ -= held;
  return HasRoom(held, wanted);
}

bool ByteBudget::Resize(uint64_t held, uint64_t wanted,
                        std::chrono::milliseconds patience) {
  const absl::MutexLock lock(&mutex_);
  if (!HasRoom(held, wanted) && !AwaitRoom(held, wanted, patience)) {
    return false;
  }
  used_bytes_ = used_bytes_ - held + wanted;
  return true;
}

ByteLease::ByteLease(ByteLease&& other) noexcept
    : budget_(std::exchange(other.budget_, nullptr)),
      bytes_(std::exchange(other.bytes_, 0)) {}

ByteLease& ByteLease::operator=(ByteLease&& other) noexcept {
  if (this != &other) {
    Release();
    budget_ = std::exchange(other.budget_, nullptr);
    bytes_ = std::exchange(other.bytes_, 0);
  }
  return *this;
}

bool ByteLease::Resize(uint64_t bytes, std::chrono::milliseconds patience) {
  if (budget_ != nullptr && bytes != bytes_ &&
      !budget_->Resize(bytes_, bytes, patience)) {
    return false;
  }
  bytes_ = bytes;
  return true;
}

absl::Status NoMemoryForRequest() {
  constexpr std::chrono::milliseconds kRetryAfter{100};
  return WithRetryAfter(
      WithReason(absl::UnavailableError(
                     "overloaded: other requests leave no memory for this one"),
                 "OVERLOADED"),
      kRetryAfter);
}

}  // namespace treeline::base

// Memory that several may hold together, at most so much.
#ifndef COMMON_BASE_BYTE_BUDGET_H_
#define COMMON_BASE_BYTE_BUDGET_H_

#include <chrono>
#include <cstdint>
#include <set>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"

namespace treeline::base {

// Counts bytes; it holds none itself. A quarter of the total is kept for small
// leases, up to a 64th of it, so that a few giants do not shut out everyone
// else. Where all that is held is held by leases that wait for more, the
// smallest of them is refused: else all would wait for each other. Thread-safe.
// Must outlive its leases.
class ByteBudget {
 public:
  explicit ByteBudget(uint64_t total_bytes) : total_bytes_(total_bytes) {}

  uint64_t total_bytes() const { return total_bytes_; }
  uint64_t used_bytes() const;

 private:
  friend class ByteLease;

  // What a waiting lease holds, and how late it came, negated.
  using Waiting = std::pair<uint64_t, int64_t>;

  // What a lease of `held` bytes that asks for `wanted` is told.
  bool HasRoom(uint64_t held, uint64_t wanted) const
      ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  bool Resize(uint64_t held, uint64_t wanted,
              std::chrono::milliseconds patience);
  // Whether there is room before `patience` ends and before this one must give
  // up for others.
  bool AwaitRoom(uint64_t held, uint64_t wanted,
                 std::chrono::milliseconds patience)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const uint64_t total_bytes_;
  mutable absl::Mutex mutex_;
  uint64_t used_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t waited_ ABSL_GUARDED_BY(mutex_) = 0;
  // Those that hold something, and how much together.
  std::set<Waiting> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t waiting_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

// A share of a budget, given back by the destructor. For one thread at a time.
class ByteLease {
 public:
  // Of no budget: every size is granted.
  ByteLease() = default;
  // Holds nothing yet. nullptr: of no budget.
  explicit ByteLease(ByteBudget* budget) : budget_(budget) {}
  ~ByteLease() { Release(); }
  ByteLease(ByteLease&& other) noexcept;
  ByteLease& operator=(ByteLease&& other) noexcept;
  ByteLease(const ByteLease&) = delete;
  ByteLease& operator=(const ByteLease&) = delete;

  uint64_t bytes() const { return bytes_; }

  // From now on holds `bytes`. Less is always granted. More waits for room for
  // up to `patience`, and is granted beyond the total where nobody else holds
  // anything: what is larger than all shares goes alone. False: there was no
  // room; the lease is as it was, and must be released for others to get on.
  bool Resize(uint64_t bytes, std::chrono::milliseconds patience =
                                  std::chrono::milliseconds(0));
  void Release() { Resize(0); }

 private:
  ByteBudget* budget_ = nullptr;
  uint64_t bytes_ = 0;
};

// What a request is told that gets no lease: UNAVAILABLE with reason OVERLOADED
// and a time to retry.
absl::Status NoMemoryForRequest();

}  // namespace treeline::base

#endif  // COMMON_BASE_BYTE_BUDGET_H_

#include "server/gateway/pending_call.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cstdint>

#include "common/base/error_info.h"

namespace treeline::gateway {
namespace {

// For poll(): -1 waits for ever.
int PollTimeoutMs(base::MonotonicTime deadline, const base::Clock& clock) {
  if (deadline == base::MonotonicTime::max()) return -1;
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(deadline - clock.Now());
  return static_cast<int>(std::clamp<int64_t>(left.count(), 0, INT_MAX));
}

}  // namespace

CallSignal::CallSignal() : fd_(eventfd(0, EFD_CLOEXEC)) {}

CallSignal::~CallSignal() {
  if (fd_ >= 0) close(fd_);
}

void CallSignal::Notify() const {
  const uint64_t one = 1;
  while (write(fd_, &one, sizeof(one)) < 0 && errno == EINTR) {
  }
}

void CallSignal::Clear() const {
  uint64_t count = 0;
  while (read(fd_, &count, sizeof(count)) < 0 && errno == EINTR) {
  }
}

void CallSignal::Wait(int socket, base::MonotonicTime deadline,
                      const base::Clock& clock, std::stop_source& stop) const {
  // poll() passes over negative descriptors.
  std::array<pollfd, 2> polled{
      {{.fd = fd_, .events = POLLIN, .revents = 0},
       {.fd = socket, .events = POLLRDHUP, .revents = 0}}};
  for (;;) {
    const int events =
        poll(polled.data(), polled.size(), PollTimeoutMs(deadline, clock));
    if (events < 0) continue;
    if ((polled[0].revents & POLLIN) != 0) return;
    if (polled[1].revents != 0) {
      polled[1].fd = -1;
      stop.request_stop();
    }
    if (clock.Now() >= deadline) {
      deadline = base::MonotonicTime::max();
      stop.request_stop();
    }
  }
}

absl::Status DeadlineInsteadOfCancelled(absl::Status status,
                                        base::MonotonicTime deadline,
                                        const base::Clock& clock) {
  if (status.code() != absl::StatusCode::kCancelled || clock.Now() < deadline) {
    return status;
  }
  return base::WithReason(absl::DeadlineExceededError("the deadline passed"),
                          "DEADLINE_EXCEEDED");
}

}  // namespace treeline::gateway

#include "common/http/stream_duplex.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <climits>
#include <cstdint>

namespace treeline::http {

HttpDuplex::Readiness StreamDuplex::Wait(bool reads, int other,
                                         base::MonotonicTime until) {
  const bool has_buffered = reads && stream_.HasBuffered();
  if (is_arriving_ && reads) until = std::min(until, stream_.deadline());
  // poll() passes over negative descriptors. One that is not read is still
  // watched: a client that has gone wants no answer.
  std::array<pollfd, 2> polled{
      {{.fd = socket_, .events = POLLRDHUP, .revents = 0},
       {.fd = other, .events = POLLIN, .revents = 0}}};
  if (reads) polled[0].events |= POLLIN;
  int64_t timeout_ms = 0;
  if (!has_buffered) {
    timeout_ms =
        until == base::MonotonicTime::max()
            ? -1
            : std::clamp<int64_t>(std::chrono::ceil<std::chrono::milliseconds>(
                                      until - clock_.Now())
                                      .count(),
                                  0, INT_MAX);
  }
  const int events =
      poll(polled.data(), polled.size(), static_cast<int>(timeout_ms));
  if (events < 0) return {};
  // The client is late: reading says so.
  const bool is_late =
      is_arriving_ && reads && clock_.Now() >= stream_.deadline();
  return {
      .can_read = has_buffered || polled[0].revents != 0 || is_late,
      .other = (polled[1].revents & POLLIN) != 0,
      .has_gone = (polled[0].revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0};
}

}  // namespace treeline::http

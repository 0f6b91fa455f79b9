// The byte stream that all others are made of.
#ifndef NAV_AGENT_DRIVERS_STREAM_DESCRIPTOR_STREAM_H_
#define NAV_AGENT_DRIVERS_STREAM_DESCRIPTOR_STREAM_H_

#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::stream {

// Owns `fd`, which is made non-blocking: a terminal or a connected socket.
absl::StatusOr<std::unique_ptr<ByteStream>> MakeDescriptorStream(
    int fd, std::string name);

// Two streams that are connected with each other, for tests.
absl::StatusOr<
    std::pair<std::unique_ptr<ByteStream>, std::unique_ptr<ByteStream>>>
MakeStreamPair();

enum class WaitOutcome { kReady, kTimedOut, kStopped };
// Waits until poll() says something of `fd` (events: POLLIN or POLLOUT), be it
// an error.
absl::StatusOr<WaitOutcome> WaitForDescriptor(int fd, short events,
                                              std::chrono::milliseconds timeout,
                                              const std::stop_token& stop);

// `message`, and the system's reason for `error` (an errno).
absl::Status SystemError(absl::StatusCode code, absl::string_view message,
                         int error);

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_DESCRIPTOR_STREAM_H_

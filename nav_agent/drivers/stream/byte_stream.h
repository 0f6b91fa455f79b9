// What lies between a driver and its device: bytes in both directions, over a
// serial port, a TCP connection or a pseudo terminal.
#ifndef NAV_AGENT_DRIVERS_STREAM_BYTE_STREAM_H_
#define NAV_AGENT_DRIVERS_STREAM_BYTE_STREAM_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::stream {

// One open connection, closed by its destructor. One thread may read while
// another writes; several readers, or several writers, must take turns.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  // Waits until something has arrived, at most for `timeout`, and not beyond
  // a request to stop. Returns how many bytes it put at the front of `buffer`
  // (which is not empty); 0 if nothing came in time, or stop was requested.
  // UNAVAILABLE once the other side is gone (unplugged, closed, reset), with
  // the system's reason; the stream is then of no more use.
  virtual absl::StatusOr<size_t> Read(std::span<uint8_t> buffer,
                                      std::chrono::milliseconds timeout,
                                      const std::stop_token& stop) = 0;

  // Writes from the front of `bytes` what the other side takes within `timeout`
  // (0: what fits into the system's buffer now), and returns how many that
  // were. UNAVAILABLE if it is gone.
  virtual absl::StatusOr<size_t> WriteSome(
      std::span<const uint8_t> bytes, std::chrono::milliseconds timeout) = 0;
  // Writes all of `bytes`. UNAVAILABLE if the other side is gone, or did not
  // take them all within `timeout`; how many were sent is then unknown, so
  // close the stream, or be sure that the protocol recovers.
  absl::Status Write(std::span<const uint8_t> bytes,
                     std::chrono::milliseconds timeout);

  // For messages: "/dev/ttyACM0", "tcp:192.168.0.10:10940".
  virtual std::string Name() const = 0;
};

// Opens the same connection again and again, so that drivers can reconnect.
class ByteStreamOpener {
 public:
  virtual ~ByteStreamOpener() = default;
  // Waits no longer than the implementation's own time limit, and not beyond
  // a request to stop (CANCELLED). NOT_FOUND, PERMISSION_DENIED,
  // INVALID_ARGUMENT (not a serial port) and UNAVAILABLE say what to do;
  // all of them may go away by themselves, when someone plugs the device in.
  virtual absl::StatusOr<std::unique_ptr<ByteStream>> Open(
      const std::stop_token& stop) = 0;
  virtual std::string Name() const = 0;
};

// Waits for `duration`. True at once when stop is requested.
bool StopRequestedWithin(std::chrono::nanoseconds duration,
                         const std::stop_token& stop);

inline std::span<const uint8_t> AsBytes(absl::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}
inline absl::string_view AsText(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_BYTE_STREAM_H_

// Byte streams over TCP: to sensors with an Ethernet socket, and from drivers
// to emulators.
#ifndef NAV_AGENT_DRIVERS_STREAM_TCP_STREAM_H_
#define NAV_AGENT_DRIVERS_STREAM_TCP_STREAM_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/descriptor.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::stream {

struct TcpStreamOptions {
  // A name or an address (IPv4, or IPv6 without brackets).
  std::string host;
  int port = 0;  // [1, 65535]
  // For the connection to be made; looking the name up is not counted.
  double connect_timeout_s = 2.0;

  absl::Status Validate() const;
};

// Connects. Small writes are sent at once (TCP_NODELAY), and a peer that has
// fallen silent without closing (a pulled cable) is noticed within about five
// seconds (keep-alive). UNAVAILABLE says why nothing was reached; CANCELLED
// when stop was requested.
absl::StatusOr<std::unique_ptr<ByteStream>> ConnectTcp(
    const TcpStreamOptions& options, const std::stop_token& stop);

class TcpOpener final : public ByteStreamOpener {
 public:
  explicit TcpOpener(TcpStreamOptions options) : options_(std::move(options)) {}
  absl::StatusOr<std::unique_ptr<ByteStream>> Open(
      const std::stop_token& stop) override;
  std::string Name() const override;

 private:
  TcpStreamOptions options_;
};

// Waits for connections; for emulators and tests.
class TcpListener {
 public:
  // Port 0: any that is free. Only this machine can connect unless another
  // address ("0.0.0.0", "::") is given. UNAVAILABLE if the port is taken.
  static absl::StatusOr<std::unique_ptr<TcpListener>> Listen(
      int port, const std::string& address = "127.0.0.1");

  int port() const { return port_; }
  // The next connection; null if none came in time or stop was requested.
  absl::StatusOr<std::unique_ptr<ByteStream>> Accept(
      std::chrono::milliseconds timeout, const std::stop_token& stop);

 private:
  TcpListener(int fd, int port) : fd_(fd), port_(port) {}
  base::Descriptor fd_;
  int port_;
};

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_TCP_STREAM_H_

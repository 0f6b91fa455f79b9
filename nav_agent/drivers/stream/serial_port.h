// Serial ports: real ones, USB adapters (FTDI), USB devices that look like one
// (CDC ACM), and pseudo terminals.
#ifndef NAV_AGENT_DRIVERS_STREAM_SERIAL_PORT_H_
#define NAV_AGENT_DRIVERS_STREAM_SERIAL_PORT_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::stream {

struct SerialPortOptions {
  // Such as /dev/ttyACM0. Names that survive replugging lie under
  // /dev/serial/by-id.
  std::string path;
  // Bits per second: any of the usual rates from 9600 to 4000000, 460800 among
  // them. USB devices that only look like a serial port do not mind which.
  int baud = 115200;
  // Asks the driver not to hold bytes back in order to send more at once: an
  // FTDI adapter otherwise waits up to 16 ms. Ports that cannot are left alone.
  bool low_latency = true;

  absl::Status Validate() const;
};

// Opens the port raw: 8 data bits, no parity, one stop bit, no flow control,
// no echo, and nothing that waits in its buffers. The port is locked, so that
// no two programs read each other's bytes. Errors:
//   NOT_FOUND          no such device: unplugged, or another name
//   PERMISSION_DENIED  says which group may open it
//   INVALID_ARGUMENT   not a serial port, or a rate that it does not know
//   UNAVAILABLE        another program has it open, or the system's reason
absl::StatusOr<std::unique_ptr<ByteStream>> OpenSerialPort(
    const SerialPortOptions& options);

class SerialPortOpener final : public ByteStreamOpener {
 public:
  explicit SerialPortOpener(SerialPortOptions options)
      : options_(std::move(options)) {}
  absl::StatusOr<std::unique_ptr<ByteStream>> Open(
      const std::stop_token& stop) override;
  std::string Name() const override { return options_.path; }

 private:
  SerialPortOptions options_;
};

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_SERIAL_PORT_H_

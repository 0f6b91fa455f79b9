// One line of text that says where a device is.
#ifndef NAV_AGENT_DRIVERS_STREAM_STREAM_ADDRESS_H_
#define NAV_AGENT_DRIVERS_STREAM_STREAM_ADDRESS_H_

#include <memory>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::stream {

// An opener for
//   /dev/ttyACM0                 a serial port
//   /dev/ttyUSB0@460800          with its rate; otherwise default_baud
//   tcp:192.168.0.10:10940       TCP; IPv6 addresses in brackets
//   tcp:192.168.0.10             with default_port, where that is not 0
// INVALID_ARGUMENT says what is wrong with the text.
absl::StatusOr<std::unique_ptr<ByteStreamOpener>> ParseStreamAddress(
    absl::string_view text, int default_baud, int default_port = 0);

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_STREAM_ADDRESS_H_

#include "nav_agent/drivers/stream/stream_address.h"

#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "nav_agent/drivers/stream/serial_port.h"
#include "nav_agent/drivers/stream/tcp_stream.h"

namespace treeline::stream {
namespace {

absl::Status Wrong(absl::string_view text, absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat(
      "\"", text, "\" is not a device address: ", why,
      " (/dev/ttyACM0, /dev/ttyUSB0@460800 or tcp:192.168.0.10:10940)"));
}

absl::StatusOr<std::unique_ptr<ByteStreamOpener>> ParseTcp(
    absl::string_view text, absl::string_view rest, int default_port) {
  TcpStreamOptions options;
  options.port = default_port;
  absl::string_view port;
  if (absl::ConsumePrefix(&rest, "[")) {
    const size_t end = rest.find(']');
    if (end == absl::string_view::npos) return Wrong(text, "no ]");
    options.host = std::string(rest.substr(0, end));
    port = rest.substr(end + 1);
  } else {
    const size_t colon = rest.find(':');
    options.host = std::string(rest.substr(0, colon));
    port = colon == absl::string_view::npos ? "" : rest.substr(colon);
  }
  if (!port.empty() && (!absl::ConsumePrefix(&port, ":") ||
                        !absl::SimpleAtoi(port, &options.port))) {
    return Wrong(text, "the port is not a number");
  }
  const absl::Status valid = options.Validate();
  if (!valid.ok()) return Wrong(text, valid.message());
  return std::make_unique<TcpOpener>(std::move(options));
}

}  // namespace

absl::StatusOr<std::unique_ptr<ByteStreamOpener>> ParseStreamAddress(
    absl::string_view text, int default_baud, int default_port) {
  absl::string_view rest = text;
  if (absl::ConsumePrefix(&rest, "tcp:")) {
    return ParseTcp(text, rest, default_port);
  }
  if (!absl::StartsWith(text, "/")) {
    return Wrong(text, "it begins neither with / nor with tcp:");
  }
  SerialPortOptions options;
  options.baud = default_baud;
  const size_t at = text.rfind('@');
  // Names under /dev/serial/by-id may hold an @ themselves.
  int baud = 0;
  const bool has_baud = at != absl::string_view::npos &&
                        absl::SimpleAtoi(text.substr(at + 1), &baud);
  if (has_baud) options.baud = baud;
  options.path = std::string(has_baud ? text.substr(0, at) : text);
  const absl::Status valid = options.Validate();
  if (!valid.ok()) return Wrong(text, valid.message());
  return std::make_unique<SerialPortOpener>(std::move(options));
}

}  // namespace treeline::stream

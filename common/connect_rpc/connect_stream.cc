#include "common/connect_rpc/connect_stream.h"

#include <poll.h>

#include "absl/status/statusor.h"
#include "common/connect_rpc/connect_message.h"

namespace treeline::connect_rpc {
namespace {

bool HasHungUp(int socket) {
  // poll() passes over a negative descriptor.
  pollfd polled{.fd = socket, .events = POLLRDHUP, .revents = 0};
  return poll(&polled, 1, /*timeout=*/0) > 0;
}

}  // namespace

ConnectStream::ConnectStream(const Options& options,
                             http::HttpBodyWriter& writer,
                             const google::protobuf::Message& empty,
                             const base::Clock& clock)
    : options_(options),
      writer_(writer),
      empty_(empty),
      clock_(clock),
      last_write_(clock.Now()) {}

bool ConnectStream::Write(const google::protobuf::Message& message) {
  if (is_gone_) return false;
  const absl::StatusOr<std::string> bytes =
      WriteConnectMessage(options_.is_json, message);
  is_gone_ = !bytes.ok() || !writer_.Write(InEnvelope(*bytes));
  last_write_ = clock_.Now();
  return !is_gone_;
}

bool ConnectStream::IsGone() {
  if (is_gone_) return true;
  if (is_past_deadline() || HasHungUp(options_.socket)) {
    is_gone_ = true;
  } else if (clock_.Now() - last_write_ >= options_.heartbeat) {
    Write(empty_);
  }
  return is_gone_;
}

}  // namespace treeline::connect_rpc

// LocalizeStream over a WebSocket: for browsers, which cannot send a stream in
// the body of a request.
#ifndef SERVER_GATEWAY_LOCALIZE_SOCKET_H_
#define SERVER_GATEWAY_LOCALIZE_SOCKET_H_

#include <cstddef>
#include <functional>
#include <optional>

#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "server/service/dispatcher.h"

namespace treeline::gateway {

struct LocalizeSocketOptions {
  // Of one message.
  size_t max_message_bytes = size_t{32} << 20;
  // What messages are held by, from their first byte to their answer; nullptr:
  // without a bound. Must outlive the streams.
  base::ByteBudget* budget = nullptr;
  // For how long a stream may have nothing to do.
  std::chrono::milliseconds idle_timeout{60000};
  // See CallInfo.
  bool admin_listener = false;
  // Whether streams go on; false: they end when what has been read is answered.
  // Empty function: always.
  std::function<bool()> goes_on = {};
};

// GET /treeline.v1.RelocalizationService/LocalizeStream opens it. Each message
// of the client is a LocalizeStreamRequest, each of the server a
// LocalizeStreamResponse: binary ones in protobuf's format, text ones in JSON,
// and answered as they came. Each frame goes to the dispatcher as a call of its
// own, as over gRPC. Thread-safe.
class LocalizeSocket {
 public:
  // Keeps references to `dispatcher` and `clock`.
  LocalizeSocket(service::Dispatcher& dispatcher, const base::Clock& clock,
                 LocalizeSocketOptions options)
      : dispatcher_(dispatcher), clock_(clock), options_(std::move(options)) {}

  // A GET of the stream's path.
  static bool Owns(const http::HttpRequest& request);

  // 426: no WebSocket is asked for; 400: not in a way that is known; and what
  // access says. Nothing of the client is read before that.
  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) const;

  // Of requests that CheckHead lets through.
  http::HttpResponse Handle(const http::HttpRequest& request) const;

 private:
  service::Dispatcher& dispatcher_;
  const base::Clock& clock_;
  const LocalizeSocketOptions options_;
};

// The protocol of the stream, and how a browser, which cannot set headers here,
// sends its token beside it: as a protocol of its own, this prefix and the
// token.
inline constexpr absl::string_view kSocketProtocol = "treeline.v1";
inline constexpr absl::string_view kTokenProtocolPrefix = "treeline.bearer.";
// The same for the header traceparent, of all frames.
inline constexpr absl::string_view kTraceProtocolPrefix =
    "treeline.traceparent.";

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_LOCALIZE_SOCKET_H_

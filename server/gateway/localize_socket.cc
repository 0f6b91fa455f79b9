#include "server/gateway/localize_socket.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/connect_rpc/connect_error.h"
#include "common/http/web_socket.h"
#include "server/gateway/call_headers.h"
#include "server/gateway/localize_stream_session.h"

namespace treeline::gateway {
namespace {

constexpr char kPath[] = "/treeline.v1.RelocalizationService/LocalizeStream";
constexpr char kRpc[] = "LocalizeStream";

// What the protocols say in place of headers becomes those, where there are
// none.
http::HttpRequest WithHeaders(const http::HttpRequest& request) {
  http::HttpRequest with_headers = request;
  const bool has_token = !request.Header("authorization").empty();
  const bool has_trace = !request.Header("traceparent").empty();
  for (const std::string& protocol : http::WebSocketProtocols(request)) {
    absl::string_view value = protocol;
    if (absl::ConsumePrefix(&value, kTokenProtocolPrefix)) {
      if (!has_token) {
        with_headers.headers["authorization"] = absl::StrCat("Bearer ", value);
      }
    } else if (absl::ConsumePrefix(&value, kTraceProtocolPrefix)) {
      if (!has_trace) with_headers.headers["traceparent"] = std::string(value);
    }
  }
  return with_headers;
}

// The one that is spoken here, if the client names any.
absl::string_view ProtocolOf(const std::vector<std::string>& protocols) {
  return protocols.empty() ? absl::string_view() : kSocketProtocol;
}

http::HttpResponse Invalid(absl::string_view message) {
  return connect_rpc::ConnectErrorResponse(
      connect_rpc::InvalidRequest(message));
}

}  // namespace

bool LocalizeSocket::Owns(const http::HttpRequest& request) {
  return request.method == "GET" && request.path == kPath;
}

std::optional<http::HttpResponse> LocalizeSocket::CheckHead(
    const http::HttpRequest& request) const {
  if (!http::AsksForWebSocket(request)) {
    http::HttpResponse response = connect_rpc::ConnectErrorResponse(
        426, base::WithReason(absl::UnimplementedError(
                                  "over HTTP, LocalizeStream is a WebSocket"),
                              "METHOD_UNKNOWN"));
    response.headers.emplace_back("Upgrade", "websocket");
    return response;
  }
  const std::vector<std::string> protocols = http::WebSocketProtocols(request);
  if (!protocols.empty() && std::find(protocols.begin(), protocols.end(),
                                      kSocketProtocol) == protocols.end()) {
    return Invalid(absl::StrCat("sec-websocket-protocol: only ",
                                kSocketProtocol, " is known"));
  }
  if (!http::AcceptWebSocket(request, ProtocolOf(protocols)).has_value()) {
    return Invalid("not a WebSocket of version 13 (RFC 6455)");
  }
  const absl::StatusOr<service::CallInfo> call =
      CallInfoOf(WithHeaders(request), kRpc, options_.admin_listener);
  const absl::Status identified =
      call.ok()
          ? dispatcher_.Identify(*call, service::Scope::kLocalize).status()
          : call.status();
  if (identified.ok()) return std::nullopt;
  return connect_rpc::ConnectErrorResponse(identified);
}

http::HttpResponse LocalizeSocket::Handle(
    const http::HttpRequest& request) const {
  absl::StatusOr<service::CallInfo> call =
      CallInfoOf(WithHeaders(request), kRpc, options_.admin_listener);
  std::optional<http::HttpResponse> response = http::AcceptWebSocket(
      request, ProtocolOf(http::WebSocketProtocols(request)));
  if (!call.ok() || !response.has_value()) {
    return Invalid("not a WebSocket of version 13 (RFC 6455)");
  }
  // Each frame says itself how long it may take.
  call->deadline = base::MonotonicTime::max();
  response->upgrade = [this,
                       call = *std::move(call)](http::HttpDuplex& connection) {
    LocalizeStreamSession(dispatcher_, clock_, options_, call, connection)
        .Run();
  };
  return *std::move(response);
}

}  // namespace treeline::gateway

#include "nav_agent/bridge/foxglove/foxglove_server.h"

#include <algorithm>
#include <chrono>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/base/status_macros.h"
#include "common/http/web_socket.h"
#include "nav_agent/bridge/foxglove/foxglove_protocol.h"
#include "nav_agent/bridge/foxglove/foxglove_session.h"
#include "nav_agent/service/stream_slot.h"

namespace treeline::foxglove {
namespace {

// The handshake has no body.
constexpr int kMaxBody_mib = 1;
// Beside viewers, those that are told why they may not watch.
constexpr int kMoreConnections = 16;
// A viewer sees within a look that the hub is closed.
constexpr auto kGrace = std::chrono::seconds(1);

http::HttpResponse Refused(int status, const std::string& why) {
  return {.status = status,
          .content_type = "text/plain; charset=utf-8",
          .body = why + "\n"};
}

// The first of those that are spoken here that the client names; empty: none.
absl::string_view ProtocolOf(const http::HttpRequest& request) {
  const std::vector<std::string> named = http::WebSocketProtocols(request);
  for (const absl::string_view protocol : kProtocols) {
    if (std::find(named.begin(), named.end(), protocol) != named.end()) {
      return protocol;
    }
  }
  return {};
}

}  // namespace

absl::StatusOr<std::unique_ptr<FoxgloveServer>> FoxgloveServer::Start(
    const agent_service::AgentInfo& info, const agent_service::AgentHub& hub,
    const agent_service::PictureKeeper* camera, FoxgloveServerOptions options,
    const base::Clock& clock) {
  http::HttpServerOptions http;
  http.listen = options.listen;
  http.insecure_any_address = options.insecure_any_address;
  http.max_body_mib = kMaxBody_mib;
  http.max_connections = options.max_viewers + kMoreConnections;
  std::unique_ptr<FoxgloveServer> made = absl::WrapUnique(
      new FoxgloveServer(info, hub, camera, std::move(options), clock));
  TL_ASSIGN_OR_RETURN(made->server_,
                      http::HttpServer::Start(http, *made, clock));
  return made;
}

FoxgloveServer::FoxgloveServer(const agent_service::AgentInfo& info,
                               const agent_service::AgentHub& hub,
                               const agent_service::PictureKeeper* camera,
                               FoxgloveServerOptions options,
                               const base::Clock& clock)
    : info_(info),
      hub_(hub),
      camera_(camera),
      options_(std::move(options)),
      clock_(clock),
      session_id_(absl::StrCat(absl::ToUnixMicros(absl::Now()))) {}

FoxgloveServer::~FoxgloveServer() {
  if (server_ != nullptr) server_->Stop(kGrace);
}

bool FoxgloveServer::IsAllowed(absl::string_view origin) const {
  return origin.empty() ||
         std::any_of(options_.origins.begin(), options_.origins.end(),
                     [origin](const std::string& allowed) {
                       return allowed == "*" || allowed == origin;
                     });
}

std::optional<http::HttpResponse> FoxgloveServer::CheckHead(
    const http::HttpRequest& request) {
  if (request.method != "GET" || !http::AsksForWebSocket(request)) {
    http::HttpResponse response =
        Refused(426, absl::StrCat("This is no page. Open a connection to ws://",
                                  request.Header("host"),
                                  " in Foxglove (Foxglove WebSocket)."));
    response.headers.emplace_back("Upgrade", "websocket");
    return response;
  }
  // A page of any site could watch a robot that this browser reaches.
  const absl::string_view origin = request.Header("origin");
  if (!IsAllowed(origin)) {
    return Refused(403, absl::StrCat("Pages of ", origin,
                                     " may not watch; foxglove_origins says "
                                     "whose may."));
  }
  const absl::string_view protocol = ProtocolOf(request);
  if (protocol.empty()) {
    return Refused(400, absl::StrCat("sec-websocket-protocol: only ",
                                     kProtocols[0], " is spoken here."));
  }
  if (!http::AcceptWebSocket(request, protocol).has_value()) {
    return Refused(400, "Not a WebSocket of version 13 (RFC 6455).");
  }
  return std::nullopt;
}

http::HttpResponse FoxgloveServer::Handle(const http::HttpRequest& request) {
  std::optional<http::HttpResponse> response =
      http::AcceptWebSocket(request, ProtocolOf(request));
  if (!response.has_value()) return Refused(400, "Not a WebSocket.");
  response->upgrade = [this](http::HttpDuplex& connection) {
    Watch(connection);
  };
  return *std::move(response);
}

void FoxgloveServer::Watch(http::HttpDuplex& connection) {
  const agent_service::StreamSlot slot(viewers_, options_.max_viewers);
  if (!slot.is_taken()) {
    connection.Write(http::WebSocketCloseFrame(
        http::WebSocketClose::kTryAgainLater,
        absl::StrCat(options_.max_viewers, " are watching already")));
    return;
  }
  FoxgloveSession(hub_, LiveTopics(info_, hub_, camera_), clock_, connection)
      .Run(absl::StrCat("treeline-agent ", info_.version), session_id_);
}

http::HttpResponse FoxgloveServer::Error(int status) {
  return Refused(status, absl::StrCat("Error ", status));
}

std::vector<std::pair<std::string, std::string>> FoxgloveServer::CommonHeaders(
    const http::HttpRequest& /*request*/) {
  return {};
}

}  // namespace treeline::foxglove

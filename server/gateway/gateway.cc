#include "server/gateway/gateway.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_error.h"
#include "common/connect_rpc/connect_router.h"
#include "server/gateway/ar_page.h"
#include "server/gateway/call_headers.h"
#include "server/gateway/connect_services.h"
#include "server/gateway/cors.h"
#include "server/gateway/gpp_routes.h"
#include "server/gateway/localize_socket.h"
#include "server/gateway/picture_routes.h"

namespace treeline::gateway {
namespace {

using connect_rpc::ConnectRouter;

constexpr absl::string_view kFailedQueries = "/failed-queries";
constexpr char kPlainText[] = "text/plain; charset=utf-8";

http::HttpResponse Text(int status, std::string text) {
  return {
      .status = status, .content_type = kPlainText, .body = std::move(text)};
}

http::HttpResponse Shown(Content content) {
  return {.status = 200,
          .content_type = std::move(content.type),
          .body = std::move(content.bytes)};
}

http::HttpResponse NoSuchPath() {
  return connect_rpc::ConnectErrorResponse(
      404, base::WithReason(absl::UnimplementedError("no such path"),
                            "METHOD_UNKNOWN"));
}

absl::Status StatusOfHttp(int http_status) {
  switch (http_status) {
    case 408:
      return base::WithReason(
          absl::DeadlineExceededError("the request did not arrive in time"),
          "REQUEST_TIMEOUT");
    case 411:
      return base::WithReason(
          absl::InvalidArgumentError("the request has no content-length"),
          "INVALID_REQUEST");
    case 413:
      return base::WithReason(
          absl::ResourceExhaustedError("the body is larger than the server "
                                       "accepts"),
          "REQUEST_TOO_LARGE");
    case 414:
    case 431:
      return base::WithReason(
          absl::ResourceExhaustedError("the headers are larger than the "
                                       "server accepts"),
          "REQUEST_TOO_LARGE");
    case 415:
      return base::WithReason(
          absl::InvalidArgumentError("the content-encoding must be gzip or "
                                     "identity"),
          "INVALID_REQUEST");
    case 500:
      return absl::InternalError("a fault of the server");
    case 503:
      return base::WithReason(
          absl::UnavailableError("overloaded: other requests take all there "
                                 "is of connections or memory"),
          "OVERLOADED");
    default:
      return base::WithReason(
          absl::InvalidArgumentError("not a valid HTTP request"),
          "INVALID_REQUEST");
  }
}

connect_rpc::ConnectRouterOptions ConnectOptionsOf(
    const http::HttpServerOptions& http) {
  return {.max_request_bytes = static_cast<size_t>(http.max_body_mib) << 20,
          .budget = http.budget};
}

OwnPages OwnPagesOf(const GatewayOptions& options) {
  if (options.ar_page_folder.empty()) return OwnPages::kNone;
  return options.http.tls.has_value() ? OwnPages::kOverTls
                                      : OwnPages::kOverHttp;
}

LocalizeSocketOptions SocketOptionsOf(const GatewayOptions& options,
                                      const GatewayHooks& hooks) {
  return {.max_message_bytes = static_cast<size_t>(options.http.max_body_mib)
                               << 20,
          .budget = options.http.budget,
          .idle_timeout = options.http.idle_timeout,
          .admin_listener = options.serve_admin,
          .goes_on = hooks.ready};
}

class Handler final : public http::HttpHandler {
 public:
  Handler(const GatewayOptions& options, service::Dispatcher& dispatcher,
          GatewayHooks hooks, const base::Clock& clock)
      : cors_(options.allowed_origins, OwnPagesOf(options)),
        hooks_(std::move(hooks)),
        admin_listener_(options.serve_admin),
        serve_metrics_(options.serve_metrics && hooks_.metrics) {
    if (!options.ar_page_folder.empty()) {
      ar_page_.emplace(options.ar_page_folder);
    }
    if (options.serve_rpc) {
      connect_.emplace(clock, ConnectOptionsOf(options.http));
      AddConnectServices(dispatcher, options.serve_admin, clock, *connect_);
      socket_.emplace(dispatcher, clock, SocketOptionsOf(options, hooks_));
      pictures_.emplace(dispatcher, options.serve_admin, clock,
                        options.http.budget);
      if (hooks_.scenes) {
        gpp_.emplace(dispatcher, hooks_.scenes, options.serve_admin, clock,
                     options.http.budget);
      }
    }
  }

  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) override {
    if (auto answer = cors_.Check(request)) return answer;
    if (socket_.has_value() && LocalizeSocket::Owns(request)) {
      if (auto answer = cors_.CheckSocket(request)) return answer;
      return socket_->CheckHead(request);
    }
    if (connect_.has_value() && ConnectRouter::Owns(request.path)) {
      return connect_->CheckHead(request);
    }
    if (pictures_.has_value() && PictureRoutes::Owns(request.path)) {
      return pictures_->CheckHead(request);
    }
    if (gpp_.has_value() && GppRoutes::Owns(request.path)) {
      return gpp_->CheckHead(request);
    }
    if (!IsPage(request)) {
      return NoSuchPath();
    }
    if (request.method != "GET" && request.method != "HEAD") {
      http::HttpResponse response = connect_rpc::ConnectErrorResponse(
          405, base::WithReason(absl::UnimplementedError("read it with GET"),
                                "METHOD_UNKNOWN"));
      response.headers.emplace_back("Allow", "GET, HEAD");
      return response;
    }
    if (request.path == "/metrics") {
      return CheckReader(request, "Metrics", hooks_.may_read_metrics);
    }
    if (IsFailedQueries(request)) {
      if (!hooks_.may_inspect) return NoSuchPath();
      return CheckReader(request, "FailedQueries", hooks_.may_inspect);
    }
    return std::nullopt;
  }

  std::optional<http::HttpResponse> Admit(http::HttpRequest& request) override {
    if (ConnectRouter::Owns(request.path)) return connect_->Admit(request);
    if (PictureRoutes::Owns(request.path)) return pictures_->Admit(request);
    if (GppRoutes::Owns(request.path)) return gpp_->Admit(request);
    return std::nullopt;
  }

  http::HttpResponse Handle(const http::HttpRequest& request) override {
    if (LocalizeSocket::Owns(request)) return socket_->Handle(request);
    if (ConnectRouter::Owns(request.path)) return connect_->Handle(request);
    if (PictureRoutes::Owns(request.path)) return pictures_->Handle(request);
    if (GppRoutes::Owns(request.path)) return gpp_->Handle(request);
    if (IsArPage(request)) return ar_page_->Handle(request);
    if (request.path == "/metrics") {
      return Shown(hooks_.metrics(request.Header("accept")));
    }
    if (IsFailedQueries(request)) return ShowFailedQueries(request);
    if (request.path == "/readyz" && hooks_.ready && !hooks_.ready()) {
      return Text(503, "not ready\n");
    }
    return Text(200, "ok\n");
  }

  http::HttpResponse Error(int status) override {
    return connect_rpc::ConnectErrorResponse(status, StatusOfHttp(status));
  }

  std::vector<std::pair<std::string, std::string>> CommonHeaders(
      const http::HttpRequest& request) override {
    auto headers = cors_.Headers(request);
    headers.emplace_back("X-Content-Type-Options", "nosniff");
    if (IsArPage(request)) {
      // How long its files may be kept, the page says itself.
      for (auto& header : ArPage::Headers()) {
        headers.push_back(std::move(header));
      }
    } else {
      headers.emplace_back("Cache-Control", "no-store");
    }
    return headers;
  }

 private:
  bool IsPage(const http::HttpRequest& request) const {
    return IsProbe(request) || IsArPage(request) || IsFailedQueries(request) ||
           (serve_metrics_ && request.path == "/metrics");
  }

  bool IsArPage(const http::HttpRequest& request) const {
    return ar_page_.has_value() && ArPage::Owns(request.path);
  }

  bool IsFailedQueries(const http::HttpRequest& request) const {
    absl::string_view path = request.path;
    return hooks_.failed_queries &&
           absl::ConsumePrefix(&path, kFailedQueries) &&
           (path.empty() || path.front() == '/');
  }

  http::HttpResponse ShowFailedQueries(const http::HttpRequest& request) const {
    absl::string_view path = request.path;
    absl::ConsumePrefix(&path, kFailedQueries);
    absl::ConsumePrefix(&path, "/");
    absl::StatusOr<Content> content = hooks_.failed_queries(path);
    if (!content.ok()) {
      return connect_rpc::ConnectErrorResponse(content.status());
    }
    return Shown(*std::move(content));
  }

  // OK is nullopt.
  std::optional<http::HttpResponse> CheckReader(
      const http::HttpRequest& request, const char* what,
      const std::function<absl::Status(const service::CallInfo&)>& may) const {
    if (!may) return std::nullopt;
    const absl::StatusOr<service::CallInfo> call =
        CallInfoOf(request, what, admin_listener_);
    const absl::Status status = call.ok() ? may(*call) : call.status();
    if (status.ok()) return std::nullopt;
    return connect_rpc::ConnectErrorResponse(status);
  }

  const CorsPolicy cors_;
  const GatewayHooks hooks_;
  const bool admin_listener_;
  const bool serve_metrics_;
  std::optional<ArPage> ar_page_;
  std::optional<ConnectRouter> connect_;
  std::optional<LocalizeSocket> socket_;
  std::optional<PictureRoutes> pictures_;
  std::optional<GppRoutes> gpp_;
};

}  // namespace

absl::Status GatewayOptions::Validate() const {
  TL_RETURN_IF_ERROR(http.Validate());
  return CorsPolicy::Validate(allowed_origins);
}

// Destroyed from the last to the first: the server before what it calls.
struct Gateway::Parts {
  Parts(const GatewayOptions& options, service::Dispatcher& dispatcher,
        GatewayHooks hooks, const base::Clock& clock)
      : handler(options, dispatcher, std::move(hooks), clock) {}

  Handler handler;
  std::unique_ptr<http::HttpServer> server;
};

Gateway::Gateway(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Gateway::~Gateway() = default;

absl::StatusOr<std::unique_ptr<Gateway>> Gateway::Start(
    const GatewayOptions& options, service::Dispatcher& dispatcher,
    GatewayHooks hooks, const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  auto parts =
      std::make_unique<Parts>(options, dispatcher, std::move(hooks), clock);
  TL_ASSIGN_OR_RETURN(parts->server, http::HttpServer::Start(
                                         options.http, parts->handler, clock));
  return std::unique_ptr<Gateway>(new Gateway(std::move(parts)));
}

const std::string& Gateway::address() const {
  return parts_->server->address();
}

void Gateway::Stop(std::chrono::milliseconds grace) {
  parts_->server->Stop(grace);
}

}  // namespace treeline::gateway

#include "server/gateway/connect_routes.h"

#include <array>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_error.h"
#include "server/gateway/call_headers.h"
#include "server/gateway/json_message.h"
#include "server/gateway/pending_call.h"
#include "server/service/message_shape.h"

namespace treeline::gateway {
namespace {

constexpr char kJson[] = "application/json";
constexpr char kProto[] = "application/proto";

bool IsJson(const http::HttpRequest& request) {
  return MediaType(request.Header("content-type")) == kJson;
}

// What all methods need to answer a request.
struct Context {
  service::Dispatcher& dispatcher;
  bool admin_listener;
  const base::Clock& clock;
  base::ByteBudget* budget;
};

absl::Status ParseBody(const http::HttpRequest& request,
                       google::protobuf::Message& message) {
  if (!IsJson(request)) return service::ParseMessage(request.body, message);
  return base::WithReason(MessageFromJson(request.body, message),
                          "INVALID_REQUEST");
}

absl::StatusOr<http::HttpResponse> WriteBody(
    const http::HttpRequest& request, const google::protobuf::Message& answer) {
  if (!IsJson(request)) {
    return http::HttpResponse{.content_type = kProto,
                              .body = answer.SerializeAsString()};
  }
  TL_ASSIGN_OR_RETURN(std::string json, JsonFromMessage(answer));
  return http::HttpResponse{.content_type = kJson, .body = std::move(json)};
}

template <typename Request, typename Response>
absl::StatusOr<http::HttpResponse> Call(
    const Context& context, const char* rpc,
    void (service::Dispatcher::*method)(service::CallInfo, const Request&,
                                        service::Dispatcher::Done<Response>),
    const http::HttpRequest& request) {
  const absl::string_view version = request.Header("connect-protocol-version");
  if (!version.empty() && version != "1") {
    return InvalidRequest("connect-protocol-version: only 1 is known");
  }
  TL_ASSIGN_OR_RETURN(service::CallInfo call,
                      CallInfoOf(request, rpc, context.admin_listener));
  TL_ASSIGN_OR_RETURN(base::ByteLease lease,
                      LeaseForParsing(context.budget, request));
  Request message;
  TL_RETURN_IF_ERROR(ParseBody(request, message));
  // The message alone; the body is the server's.
  lease.Resize(request.body.size());
  TL_ASSIGN_OR_RETURN(const Response answer,
                      CallAndWait(context.dispatcher, method, std::move(call),
                                  message, request.socket, context.clock));
  return WriteBody(request, answer);
}

struct Route {
  absl::string_view path;
  const char* rpc;
  service::Scope scope;
  // Null: a streaming method.
  absl::StatusOr<http::HttpResponse> (*call)(const Context&,
                                             const http::HttpRequest&);
};

constexpr std::array<Route, 6> kRoutes{{
    {"/treeline.v1.RelocalizationService/Localize", "Localize",
     service::Scope::kLocalize,
     [](const Context& context, const http::HttpRequest& request) {
       return Call(context, "Localize", &service::Dispatcher::Localize,
                   request);
     }},
    {"/treeline.v1.RelocalizationService/LocalizeStream", "LocalizeStream",
     service::Scope::kLocalize, nullptr},
    {"/treeline.v1.SceneService/ListScenes", "ListScenes",
     service::Scope::kLocalize,
     [](const Context& context, const http::HttpRequest& request) {
       return Call(context, "ListScenes", &service::Dispatcher::ListScenes,
                   request);
     }},
    {"/treeline.v1.SceneService/GetScene", "GetScene",
     service::Scope::kLocalize,
     [](const Context& context, const http::HttpRequest& request) {
       return Call(context, "GetScene", &service::Dispatcher::GetScene,
                   request);
     }},
    {"/treeline.v1.SceneService/LoadScene", "LoadScene", service::Scope::kAdmin,
     [](const Context& context, const http::HttpRequest& request) {
       return Call(context, "LoadScene", &service::Dispatcher::LoadScene,
                   request);
     }},
    {"/treeline.v1.SceneService/UnloadScene", "UnloadScene",
     service::Scope::kAdmin,
     [](const Context& context, const http::HttpRequest& request) {
       return Call(context, "UnloadScene", &service::Dispatcher::UnloadScene,
                   request);
     }},
}};

const Route* FindRoute(absl::string_view path) {
  for (const Route& route : kRoutes) {
    if (route.path == path) return &route;
  }
  return nullptr;
}

}  // namespace

ConnectRoutes::ConnectRoutes(service::Dispatcher& dispatcher,
                             bool admin_listener, const base::Clock& clock,
                             base::ByteBudget* budget)
    : dispatcher_(dispatcher),
      admin_listener_(admin_listener),
      clock_(clock),
      budget_(budget) {}

bool ConnectRoutes::Owns(absl::string_view path) {
  return absl::StartsWith(path, "/treeline.v1.");
}

std::optional<http::HttpResponse> ConnectRoutes::CheckHead(
    const http::HttpRequest& request) const {
  const Route* route = FindRoute(request.path);
  if (route == nullptr) {
    return connect_rpc::ConnectErrorResponse(
        404, base::WithReason(absl::UnimplementedError("no such method"),
                              "METHOD_UNKNOWN"));
  }
  if (request.method != "POST") {
    http::HttpResponse response = connect_rpc::ConnectErrorResponse(
        405,
        base::WithReason(absl::UnimplementedError("calls are made with POST"),
                         "METHOD_UNKNOWN"));
    response.headers.emplace_back("Allow", "POST");
    return response;
  }
  if (route->call == nullptr) {
    return connect_rpc::ConnectErrorResponse(base::WithReason(
        absl::UnimplementedError("LocalizeStream is served over gRPC only; "
                                 "over HTTP, call Localize for each frame"),
        "METHOD_UNKNOWN"));
  }
  const std::string type = MediaType(request.Header("content-type"));
  if (type != kJson && type != kProto) {
    http::HttpResponse response = connect_rpc::ConnectErrorResponse(
        415, InvalidRequest("the content-type must be application/json or "
                            "application/proto"));
    response.headers.emplace_back("Accept-Post",
                                  "application/json, application/proto");
    return response;
  }
  return std::nullopt;
}

std::optional<http::HttpResponse> ConnectRoutes::Admit(
    http::HttpRequest& request) const {
  const Route& route = *FindRoute(request.path);
  return AdmitRequest(dispatcher_, route.rpc, route.scope, admin_listener_,
                      clock_, request);
}

http::HttpResponse ConnectRoutes::Handle(
    const http::HttpRequest& request) const {
  const Context context{dispatcher_, admin_listener_, clock_, budget_};
  absl::StatusOr<http::HttpResponse> response =
      FindRoute(request.path)->call(context, request);
  return response.ok() ? *std::move(response)
                       : connect_rpc::ConnectErrorResponse(response.status());
}

}  // namespace treeline::gateway

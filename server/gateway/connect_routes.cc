#include "server/gateway/connect_routes.h"

#include <array>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/gateway/call_headers.h"
#include "server/gateway/http_errors.h"
#include "server/gateway/json_message.h"
#include "server/gateway/pending_call.h"

namespace treeline {
namespace {

constexpr char kJson[] = "application/json";
constexpr char kProto[] = "application/proto";

bool IsJson(const HttpRequest& request) {
  return MediaType(request.Header("content-type")) == kJson;
}

// What all methods need to answer a request.
struct Context {
  Dispatcher& dispatcher;
  bool admin_listener;
  const Clock& clock;
};

absl::Status ParseBody(const HttpRequest& request,
                       google::protobuf::Message& message) {
  if (!IsJson(request)) {
    if (message.ParseFromString(request.body)) return absl::OkStatus();
    return InvalidRequest(absl::StrCat("the body is not a ",
                                       message.GetTypeName(),
                                       " in protobuf's binary format"));
  }
  return WithReason(MessageFromJson(request.body, message), "INVALID_REQUEST");
}

absl::StatusOr<HttpResponse> WriteBody(
    const HttpRequest& request, const google::protobuf::Message& answer) {
  if (!IsJson(request)) {
    return HttpResponse{.content_type = kProto,
                        .body = answer.SerializeAsString()};
  }
  TL_ASSIGN_OR_RETURN(std::string json, JsonFromMessage(answer));
  return HttpResponse{.content_type = kJson, .body = std::move(json)};
}

template <typename Request, typename Response>
absl::StatusOr<HttpResponse> Call(
    const Context& context, const char* rpc,
    void (Dispatcher::*method)(CallInfo, const Request&,
                               Dispatcher::Done<Response>),
    const HttpRequest& request) {
  const absl::string_view version = request.Header("connect-protocol-version");
  if (!version.empty() && version != "1") {
    return InvalidRequest("connect-protocol-version: only 1 is known");
  }
  TL_ASSIGN_OR_RETURN(CallInfo call,
                      CallInfoOf(request, rpc, context.admin_listener));
  Request message;
  TL_RETURN_IF_ERROR(ParseBody(request, message));
  TL_ASSIGN_OR_RETURN(const Response answer,
                      CallAndWait(context.dispatcher, method, std::move(call),
                                  message, request.socket, context.clock));
  return WriteBody(request, answer);
}

struct Route {
  absl::string_view path;
  // Null: a streaming method.
  absl::StatusOr<HttpResponse> (*call)(const Context&, const HttpRequest&);
};

constexpr std::array<Route, 6> kRoutes{{
    {"/treeline.v1.RelocalizationService/Localize",
     [](const Context& context, const HttpRequest& request) {
       return Call(context, "Localize", &Dispatcher::Localize, request);
     }},
    {"/treeline.v1.RelocalizationService/LocalizeStream", nullptr},
    {"/treeline.v1.SceneService/ListScenes",
     [](const Context& context, const HttpRequest& request) {
       return Call(context, "ListScenes", &Dispatcher::ListScenes, request);
     }},
    {"/treeline.v1.SceneService/GetScene",
     [](const Context& context, const HttpRequest& request) {
       return Call(context, "GetScene", &Dispatcher::GetScene, request);
     }},
    {"/treeline.v1.SceneService/LoadScene",
     [](const Context& context, const HttpRequest& request) {
       return Call(context, "LoadScene", &Dispatcher::LoadScene, request);
     }},
    {"/treeline.v1.SceneService/UnloadScene",
     [](const Context& context, const HttpRequest& request) {
       return Call(context, "UnloadScene", &Dispatcher::UnloadScene, request);
     }},
}};

const Route* FindRoute(absl::string_view path) {
  for (const Route& route : kRoutes) {
    if (route.path == path) return &route;
  }
  return nullptr;
}

}  // namespace

ConnectRoutes::ConnectRoutes(Dispatcher& dispatcher, bool admin_listener,
                             const Clock& clock)
    : dispatcher_(dispatcher), admin_listener_(admin_listener), clock_(clock) {}

bool ConnectRoutes::Owns(absl::string_view path) {
  return absl::StartsWith(path, "/treeline.v1.");
}

std::optional<HttpResponse> ConnectRoutes::CheckHead(
    const HttpRequest& request) const {
  const Route* route = FindRoute(request.path);
  if (route == nullptr) {
    return ErrorResponse(404,
                         WithReason(absl::UnimplementedError("no such method"),
                                    "METHOD_UNKNOWN"));
  }
  if (request.method != "POST") {
    HttpResponse response = ErrorResponse(
        405, WithReason(absl::UnimplementedError("calls are made with POST"),
                        "METHOD_UNKNOWN"));
    response.headers.emplace_back("Allow", "POST");
    return response;
  }
  if (route->call == nullptr) {
    return ErrorResponse(WithReason(
        absl::UnimplementedError("LocalizeStream is served over gRPC only; "
                                 "over HTTP, call Localize for each frame"),
        "METHOD_UNKNOWN"));
  }
  const std::string type = MediaType(request.Header("content-type"));
  if (type != kJson && type != kProto) {
    HttpResponse response = ErrorResponse(
        415, InvalidRequest("the content-type must be application/json or "
                            "application/proto"));
    response.headers.emplace_back("Accept-Post",
                                  "application/json, application/proto");
    return response;
  }
  return std::nullopt;
}

HttpResponse ConnectRoutes::Handle(const HttpRequest& request) const {
  const Context context{dispatcher_, admin_listener_, clock_};
  absl::StatusOr<HttpResponse> response =
      FindRoute(request.path)->call(context, request);
  return response.ok() ? *std::move(response)
                       : ErrorResponse(response.status());
}

}  // namespace treeline

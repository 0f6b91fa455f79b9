#include "server/gateway/picture_routes.h"

#include <string>
#include <utility>

#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_error.h"
#include "common/connect_rpc/connect_message.h"
#include "server/gateway/call_headers.h"
#include "server/gateway/pending_call.h"
#include "server/gateway/picture_query.h"

namespace treeline::gateway {
namespace {

using connect_rpc::ConnectErrorResponse;

constexpr char kRpc[] = "Localize";

}  // namespace

PictureRoutes::PictureRoutes(service::Dispatcher& dispatcher,
                             bool admin_listener, const base::Clock& clock,
                             base::ByteBudget* budget)
    : dispatcher_(dispatcher),
      admin_listener_(admin_listener),
      clock_(clock),
      budget_(budget) {}

std::optional<http::HttpResponse> PictureRoutes::CheckHead(
    const http::HttpRequest& request) const {
  if (request.method != "POST") {
    http::HttpResponse response = ConnectErrorResponse(
        405, base::WithReason(
                 absl::UnimplementedError(
                     "send a picture with POST: curl -F image=@photo.jpg -F "
                     "scene=NAME http://HOST:PORT/localize"),
                 "METHOD_UNKNOWN"));
    response.headers.emplace_back("Allow", "POST");
    return response;
  }
  if (!MayBePicture(request.Header("content-type"))) {
    return ConnectErrorResponse(
        415, connect_rpc::InvalidRequest(
                 "the body must be a picture, or multipart/form-data with one; "
                 "JSON goes to /treeline.v1.RelocalizationService/Localize"));
  }
  return std::nullopt;
}

std::optional<http::HttpResponse> PictureRoutes::Admit(
    http::HttpRequest& request) const {
  const absl::Status admitted =
      AdmitRequest(dispatcher_, kRpc, service::Scope::kLocalize,
                   admin_listener_, clock_, request);
  if (admitted.ok()) return std::nullopt;
  return ConnectErrorResponse(admitted);
}

http::HttpResponse PictureRoutes::Handle(
    const http::HttpRequest& request) const {
  absl::StatusOr<http::HttpResponse> response = Localize(request);
  return response.ok() ? *std::move(response)
                       : ConnectErrorResponse(response.status());
}

absl::StatusOr<http::HttpResponse> PictureRoutes::Localize(
    const http::HttpRequest& http) const {
  TL_ASSIGN_OR_RETURN(service::CallInfo call,
                      CallInfoOf(http, kRpc, admin_listener_));
  TL_ASSIGN_OR_RETURN(const base::ByteLease lease,
                      connect_rpc::LeaseForParsing(budget_, /*is_json=*/false,
                                                   http.body.size()));
  TL_ASSIGN_OR_RETURN(const v1::LocalizeRequest query, ParsePictureQuery(http));
  TL_ASSIGN_OR_RETURN(const v1::LocalizeResponse answer,
                      CallAndWait(dispatcher_, &service::Dispatcher::Localize,
                                  std::move(call), query, http.socket, clock_));
  TL_ASSIGN_OR_RETURN(std::string json, connect_rpc::WriteConnectMessage(
                                            /*is_json=*/true, answer));
  return http::HttpResponse{.content_type = "application/json",
                            .body = std::move(json)};
}

}  // namespace treeline::gateway

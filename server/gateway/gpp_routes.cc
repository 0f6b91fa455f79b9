#include "server/gateway/gpp_routes.h"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_error.h"
#include "common/connect_rpc/connect_message.h"
#include "common/wire/camera.h"
#include "common/wire/geometry.h"
#include "server/gateway/call_headers.h"
#include "server/gateway/pending_call.h"

namespace treeline::gateway {
namespace {

using connect_rpc::InvalidRequest;
using connect_rpc::MediaType;

constexpr char kJson[] = "application/json";
constexpr char kOscpJson[] = "application/vnd.oscp+json";
constexpr char kOscpJson2[] = "application/vnd.oscp+json;version=2.0";
// Of a scene whose model has not been loaded yet.
constexpr double kUnknownExtent_m = 500;

// The farthest that a scene reaches from its anchor.
double Extent_m(const v1::SceneInfo& scene) {
  if (!scene.has_model()) return kUnknownExtent_m;
  const v1::Vector3& low = scene.model().bounds_min_in_world_m();
  const v1::Vector3& high = scene.model().bounds_max_in_world_m();
  return geometry::Norm(
      geometry::Vec3{std::max(std::abs(low.x()), std::abs(high.x())),
                     std::max(std::abs(low.y()), std::abs(high.y())),
                     std::max(std::abs(low.z()), std::abs(high.z()))});
}

// Whether the client takes version 2 of the protocol.
bool AcceptsVersion2(absl::string_view accept) {
  bool other_version = false;
  for (absl::string_view item : absl::StrSplit(accept, ',')) {
    if (MediaType(item) != kOscpJson || !absl::StrContains(item, "version=") ||
        absl::StrContains(item, "version=2")) {
      if (!absl::StripAsciiWhitespace(item).empty()) return true;
      continue;
    }
    other_version = true;
  }
  return !other_version;
}

// The protocol has no word for it, and its clients take every answer with
// status 200 for a pose.
http::HttpResponse NotLocalized(absl::string_view reason,
                                absl::string_view message,
                                const v1::LocalizeResponse* response) {
  std::map<std::string, std::string> metadata;
  if (response != nullptr) {
    metadata["inliers"] = absl::StrCat(response->inliers());
    metadata["samples"] = absl::StrCat(response->samples());
    metadata["confidence"] = absl::StrCat(response->confidence());
    if (!response->scene().empty()) metadata["scene"] = response->scene();
  }
  return connect_rpc::ConnectErrorResponse(
      422, base::WithReason(absl::NotFoundError(message), reason, metadata));
}

}  // namespace

std::vector<std::string> ScenesNear(const std::vector<v1::SceneInfo>& scenes,
                                    const std::vector<GppHint>& hints) {
  std::vector<std::string> near;
  for (const v1::SceneInfo& scene : scenes) {
    if (!scene.has_geo_anchor()) continue;
    const absl::StatusOr<GeoFrame> frame =
        GeoFrame::Create(scene.geo_anchor(), "geo_anchor");
    if (!frame.ok()) continue;
    const double extent_m = Extent_m(scene);
    const bool is_near =
        hints.empty() ||
        std::any_of(hints.begin(), hints.end(), [&](const GppHint& hint) {
          return HorizontalDistance_m(frame->anchor(), hint.position) <=
                 hint.radius_m + extent_m;
        });
    if (is_near) near.push_back(scene.scene());
  }
  return near;
}

absl::StatusOr<geometry::Rigid3> WorldFromPicture(
    const v1::LocalizeResponse& response, const v1::SceneInfo& scene,
    const v1::Frame& frame) {
  TL_ASSIGN_OR_RETURN(
      const geometry::Rigid3 world_from_camera,
      wire::FromProto(response.world_from_camera(), "world_from_camera"));
  const bool one_camera =
      frame.has_depth() && frame.depth().registration() ==
                               v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR;
  if (response.pose_sensor() != v1::RGBD_SENSOR_DEPTH || one_camera) {
    return world_from_camera;
  }
  if (!scene.has_model()) {
    return absl::InternalError("the scene's calibration is not known");
  }
  TL_ASSIGN_OR_RETURN(
      const geometry::Rigid3 color_from_depth,
      wire::FromProto(scene.model().calibration().color_from_depth(),
                      "calibration.color_from_depth"));
  return world_from_camera * color_from_depth.Inverse();
}

GppRoutes::GppRoutes(service::Dispatcher& dispatcher,
                     std::function<std::vector<v1::SceneInfo>()> scenes,
                     bool admin_listener, const base::Clock& clock,
                     base::ByteBudget* budget)
    : dispatcher_(dispatcher),
      scenes_(std::move(scenes)),
      admin_listener_(admin_listener),
      clock_(clock),
      budget_(budget) {}

std::optional<http::HttpResponse> GppRoutes::CheckHead(
    const http::HttpRequest& request) const {
  if (request.method == "GET" || request.method == "HEAD") return std::nullopt;
  if (request.method != "POST") {
    http::HttpResponse response = connect_rpc::ConnectErrorResponse(
        405,
        base::WithReason(absl::UnimplementedError("poses are asked with POST"),
                         "METHOD_UNKNOWN"));
    response.headers.emplace_back("Allow", "GET, HEAD, POST");
    return response;
  }
  const std::string type = MediaType(request.Header("content-type"));
  if (type != kJson && type != kOscpJson) {
    return connect_rpc::ConnectErrorResponse(
        415, InvalidRequest("the content-type must be application/json"));
  }
  if (!AcceptsVersion2(request.Header("accept"))) {
    return connect_rpc::ConnectErrorResponse(
        406, InvalidRequest("only version 2.0 of the GeoPose Protocol is "
                            "spoken: application/vnd.oscp+json;version=2.0"));
  }
  return std::nullopt;
}

std::optional<http::HttpResponse> GppRoutes::Admit(
    http::HttpRequest& request) const {
  const absl::Status admitted =
      AdmitRequest(dispatcher_, service::kGeoPoseRpc, service::Scope::kLocalize,
                   admin_listener_, clock_, request);
  if (admitted.ok()) return std::nullopt;
  return connect_rpc::ConnectErrorResponse(admitted);
}

http::HttpResponse GppRoutes::Handle(const http::HttpRequest& request) const {
  if (request.method != "POST") {
    return {.content_type = kJson, .body = R"({"status":"running"})"};
  }
  absl::StatusOr<http::HttpResponse> response = Localize(request);
  return response.ok() ? *std::move(response)
                       : connect_rpc::ConnectErrorResponse(response.status());
}

absl::StatusOr<http::HttpResponse> GppRoutes::Localize(
    const http::HttpRequest& http) const {
  TL_ASSIGN_OR_RETURN(service::CallInfo call,
                      CallInfoOf(http, service::kGeoPoseRpc, admin_listener_));
  TL_ASSIGN_OR_RETURN(base::ByteLease lease,
                      connect_rpc::LeaseForParsing(budget_, /*is_json=*/true,
                                                   http.body.size()));
  TL_ASSIGN_OR_RETURN(GppRequest request, ParseGppRequest(http.body));
  // The query alone; the body is the server's.
  lease.Resize(http.body.size());
  std::vector<std::string> near = ScenesNear(scenes_(), request.hints);
  if (near.empty()) {
    return NotLocalized("NO_SCENE_NEAR",
                        "no scene with a place on the Earth lies there",
                        nullptr);
  }
  v1::LocalizeRequest query;
  query.mutable_frame()->Swap(&request.frame);
  if (near.size() == 1) {
    query.set_scene(std::move(near.front()));
  } else {
    for (std::string& scene : near) {
      query.add_candidate_scenes(std::move(scene));
    }
  }
  TL_ASSIGN_OR_RETURN(const v1::LocalizeResponse response,
                      CallAndWait(dispatcher_, &service::Dispatcher::Localize,
                                  std::move(call), query, http.socket, clock_));
  if (response.outcome() != v1::OUTCOME_LOCALIZED) {
    return NotLocalized(
        absl::StripPrefix(v1::NotLocalizedReason_Name(response.reason()),
                          "NOT_LOCALIZED_REASON_"),
        "not localized", &response);
  }
  return Answer(request, response, query.frame());
}

absl::StatusOr<http::HttpResponse> GppRoutes::Answer(
    const GppRequest& request, const v1::LocalizeResponse& response,
    const v1::Frame& frame) const {
  // Asked again: the query may have loaded the model.
  const std::vector<v1::SceneInfo> scenes = scenes_();
  const auto scene = std::find_if(
      scenes.begin(), scenes.end(),
      [&](const auto& each) { return each.scene() == response.scene(); });
  if (scene == scenes.end() || !scene->has_geo_anchor()) {
    return absl::InternalError("the scene that answered has no geo_anchor");
  }
  TL_ASSIGN_OR_RETURN(const GeoFrame geo_frame,
                      GeoFrame::Create(scene->geo_anchor(), "geo_anchor"));
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 world_from_camera,
                      WorldFromPicture(response, *scene, frame));
  TL_ASSIGN_OR_RETURN(
      const GeoAccuracy accuracy,
      AccuracyOf(response.covariance().data(), response.covariance_size()));
  return http::HttpResponse{
      .content_type = kOscpJson2,
      .body = GppAnswerJson(request, geo_frame.ToGeoPose(world_from_camera),
                            accuracy)};
}

}  // namespace treeline::gateway

// GeoPose Protocol over HTTP: POST /geopose asks, GET /geopose says whether the
// service runs.
#ifndef SERVER_GATEWAY_GPP_ROUTES_H_
#define SERVER_GATEWAY_GPP_ROUTES_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "server/gateway/gpp_message.h"
#include "server/service/dispatcher.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline::gateway {

// Names of the scenes that have an anchor and lie where one of `hints` may be;
// all that have one if there are no hints. The extent of a scene is its
// model's, or 500 m while that is not known.
std::vector<std::string> ScenesNear(const std::vector<v1::SceneInfo>& scenes,
                                    const std::vector<GppHint>& hints);

// world_from_camera of the camera that took the picture: an answer may be the
// pose of the depth camera. INVALID_ARGUMENT, INTERNAL: an answer that makes no
// sense.
absl::StatusOr<geometry::Rigid3> WorldFromPicture(
    const v1::LocalizeResponse& response, const v1::SceneInfo& scene,
    const v1::Frame& frame);

// Thread-safe.
class GppRoutes {
 public:
  // `scenes`: all of the server; `admin_listener`: see CallInfo; `budget`: for
  // requests while they are parsed; nullptr: without a bound. Keeps references.
  GppRoutes(service::Dispatcher& dispatcher,
            std::function<std::vector<v1::SceneInfo>()> scenes,
            bool admin_listener, const base::Clock& clock,
            base::ByteBudget* budget = nullptr);

  static bool Owns(absl::string_view path) { return path == "/geopose"; }

  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) const;
  // Of requests that CheckHead lets through: see HttpHandler::Admit.
  std::optional<http::HttpResponse> Admit(http::HttpRequest& request) const;
  http::HttpResponse Handle(const http::HttpRequest& request) const;

 private:
  absl::StatusOr<http::HttpResponse> Localize(
      const http::HttpRequest& http) const;
  absl::StatusOr<http::HttpResponse> Answer(
      const GppRequest& request, const v1::LocalizeResponse& response,
      const v1::Frame& frame) const;

  service::Dispatcher& dispatcher_;
  const std::function<std::vector<v1::SceneInfo>()> scenes_;
  const bool admin_listener_;
  const base::Clock& clock_;
  base::ByteBudget* const budget_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_GPP_ROUTES_H_

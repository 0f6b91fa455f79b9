// The gateway with a made-up service behind it, for clients in other languages.
// Prints "listening on HOST:PORT", and ends with its standard input.
//
// Scenes: "hall", anchored at 48.137 N, 11.575 E, 520 m. A picture from
// kGoodCamera is at (1, 2, 3) there and looks along the world's z axis, one
// whose left side is up a metre higher; another one is not localized. The scene
// "slow" answers when its call is stopped.
#include <cstdio>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/error_info.h"
#include "common/wire/geometry.h"
#include "server/gateway/gateway.h"
#include "server/gateway/testing_dispatcher.h"

namespace treeline {
namespace {

// fx, fy, cx, cy as COLMAP counts pixels: 320, 240.
const std::vector<double> kGoodCamera{585, 585, 319.5, 239.5};

v1::SceneInfo Hall() {
  v1::SceneInfo scene;
  scene.set_scene("hall");
  scene.mutable_geo_anchor()->set_latitude_deg(48.137);
  scene.mutable_geo_anchor()->set_longitude_deg(11.575);
  scene.mutable_geo_anchor()->set_height_m(520);
  return scene;
}

absl::StatusOr<v1::LocalizeResponse> Localize(
    const v1::LocalizeRequest& request) {
  if (request.scene() != "hall") {
    return base::WithRetryAfter(
        base::WithReason(absl::NotFoundError("no such scene"),
                         "SCENE_NOT_FOUND"),
        std::chrono::seconds(3));
  }
  v1::LocalizeResponse response;
  response.set_scene("hall");
  response.set_samples(500);
  const auto& parameters = request.frame().camera().parameters();
  if (std::vector<double>(parameters.begin(), parameters.end()) !=
      kGoodCamera) {
    response.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
    response.set_reason(v1::NOT_LOCALIZED_REASON_TOO_FEW_INLIERS);
    return response;
  }
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  response.set_inliers(400);
  response.set_pose_sensor(v1::RGBD_SENSOR_COLOR);
  const bool lies = request.frame().orientation() == v1::ORIENTATION_LEFT_UP;
  *response.mutable_world_from_camera() =
      wire::ToProto(geometry::Rigid3{{}, {1, 2, lies ? 4.0 : 3.0}});
  for (int i = 0; i < 36; ++i) response.add_covariance(i % 7 == 0 ? 1e-4 : 0);
  return response;
}

int Main(const std::string& origin) {
  const base::SteadyClock clock{};
  gateway::TestingDispatcher dispatcher;
  dispatcher.on_localize = &Localize;
  dispatcher.scene_that_waits = "slow";
  gateway::GatewayOptions options;
  options.http.listen = "127.0.0.1:0";
  options.allowed_origins = {origin};
  const auto gateway = gateway::Gateway::Start(
      options, dispatcher,
      {.metrics =
           [&](absl::string_view /*accept*/) {
             int stopped = 0;
             for (const service::CallInfo& call : dispatcher.calls()) {
               stopped += call.stop.stop_requested() ? 1 : 0;
             }
             return gateway::Content{
                 .type = "text/plain",
                 .bytes = absl::StrCat("stopped ", stopped, "\n")};
           },
       .scenes = [] { return std::vector<v1::SceneInfo>{Hall()}; }},
      clock);
  if (!gateway.ok()) {
    std::fprintf(stderr, "%s\n", gateway.status().ToString().c_str());
    return 1;
  }
  std::printf("listening on %s\n", (*gateway)->address().c_str());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  return 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  return treeline::Main(argc > 1 ? argv[1] : "https://app.example.com");
}

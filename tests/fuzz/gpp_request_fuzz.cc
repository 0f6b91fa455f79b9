// Requests of the GeoPose Protocol as arbitrary bytes: no crash, and what is
// accepted is consistent and becomes an answer.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/decode.h"
#include "common/wire/frame.h"
#include "server/gateway/geo_pose.h"
#include "server/gateway/gpp_message.h"
#include "server/gateway/gpp_routes.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto request = treeline::gateway::ParseGppRequest(
      absl::string_view(reinterpret_cast<const char*>(data), size));
  if (!request.ok()) {
    if (request.status().code() != absl::StatusCode::kInvalidArgument) {
      std::abort();
    }
    return 0;
  }
  if (!request->frame.has_color()) std::abort();
  for (const treeline::gateway::GppHint& hint : request->hints) {
    if (!(std::abs(hint.position.latitude_deg) <= 90)) std::abort();
    if (!(hint.radius_m > 0)) std::abort();
  }
  treeline::v1::SceneInfo scene;
  scene.mutable_geo_anchor();
  treeline::gateway::ScenesNear({scene}, request->hints);
  if (treeline::gateway::GppAnswerJson(*request, {}, {}).empty()) std::abort();
  const treeline::image::DecodeLimits limits{
      .max_width = 256, .max_height = 256, .max_pixels = 1 << 14};
  const auto frame = treeline::wire::FromProto(
      request->frame, treeline::camera::RgbdCalibration{}, limits, "frame");
  if (frame.ok() && frame->color.rgb.empty()) std::abort();
  return 0;
}

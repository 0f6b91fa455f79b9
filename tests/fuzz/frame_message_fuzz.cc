// A frame as it comes from the network, as arbitrary bytes: no crash, and what
// is accepted is consistent.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "common/camera/rgbd_calibration.h"
#include "common/image/decode.h"
#include "common/image/frame.h"
#include "common/wire/frame.h"
#include "treeline/v1/frame.pb.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::v1::Frame message;
  if (!message.ParseFromArray(data, static_cast<int>(size))) return 0;
  const treeline::image::DecodeLimits limits{
      .max_width = 1024, .max_height = 1024, .max_pixels = 1 << 19};
  const auto frame = treeline::wire::FromProto(
      message, treeline::camera::RgbdCalibration{}, limits, "frame");
  if (!frame.ok()) return 0;
  const treeline::image::ColorImage& color = frame->color;
  const auto pixels = static_cast<size_t>(color.width * color.height);
  if (pixels == 0 || color.rgb.size() != 3 * pixels) std::abort();
  if (frame->depth.has_value()) {
    const treeline::image::DepthImage& depth = *frame->depth;
    const auto values = static_cast<size_t>(depth.width * depth.height);
    if (values == 0 || depth.values.size() != values) std::abort();
    if (!(depth.unit_m > 0)) std::abort();
  }
  return 0;
}

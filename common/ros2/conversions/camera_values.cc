#include "common/ros2/conversions/camera_values.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/image/millimetres.h"
#include "common/image/rvl.h"

namespace treeline::conversions {
namespace {

// Of what a depth picture of the transport begins with.
constexpr size_t kCompressedDepthHeader = 12;
constexpr double kMillimetre = 0.001;
// Beyond this a 16-bit picture in mm has no values.

constexpr image::DecodeLimits kLimits;

absl::string_view TextOf(const std::vector<uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Bytes of a pixel, and that rows are where they should be.
absl::Status CheckRows(const messages::Image& image, size_t pixel_bytes) {
  const auto pixels = uint64_t{image.width} * image.height;
  if (image.width == 0 || image.height == 0 ||
      image.width > static_cast<uint32_t>(kLimits.max_width) ||
      image.height > static_cast<uint32_t>(kLimits.max_height) ||
      pixels > static_cast<uint64_t>(kLimits.max_pixels) ||
      image.step < image.width * pixel_bytes ||
      image.data.size() < uint64_t{image.step} * image.height) {
    return absl::InvalidArgumentError(
        absl::StrCat("picture of ", image.width, " x ", image.height,
                     " pixels, ", image.encoding, ", rows of ", image.step,
                     " bytes: there are ", image.data.size()));
  }
  return absl::OkStatus();
}

// Where red, green and blue are in a pixel.
struct Layout {
  const char* encoding;
  size_t bytes;
  size_t red;
  size_t green;
  size_t blue;
};
constexpr std::array<Layout, 6> kLayouts = {{{"rgb8", 3, 0, 1, 2},
                                             {"bgr8", 3, 2, 1, 0},
                                             {"rgba8", 4, 0, 1, 2},
                                             {"bgra8", 4, 2, 1, 0},
                                             {"mono8", 1, 0, 0, 0},
                                             {"8UC1", 1, 0, 0, 0}}};

// Where luminance and the two colour differences are in the four bytes of two
// pixels (https://wiki.ros.org/sensor_msgs image_encodings.hpp).
struct YuvLayout {
  const char* encoding;
  size_t y;  // of the first pixel; that of the second is two behind
  size_t u;
  size_t v;
};
constexpr std::array<YuvLayout, 4> kYuvLayouts = {{{"yuv422", 1, 0, 2},
                                                   {"uyvy", 1, 0, 2},
                                                   {"yuv422_yuy2", 0, 1, 3},
                                                   {"yuyv", 0, 1, 3}}};

uint8_t Level(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// Red, green and blue by ITU-R BT.601, whose black is 16 and whose white 235.
void WriteRgb(uint8_t y, uint8_t u, uint8_t v, uint8_t* to) {
  const double grey = 1.164 * (y - 16);
  to[0] = Level(grey + 1.596 * (v - 128));
  to[1] = Level(grey - 0.813 * (v - 128) - 0.391 * (u - 128));
  to[2] = Level(grey + 2.018 * (u - 128));
}

template <typename T>
T ValueAt(const uint8_t* at, bool is_swapped) {
  std::array<uint8_t, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), at, sizeof(T));
  if (is_swapped) std::ranges::reverse(bytes);
  return std::bit_cast<T>(bytes);
}

struct Intrinsics {
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  // At most as many as a model of distortion has.
  std::vector<double> distortion;
};

absl::StatusOr<camera::Camera> Made(camera::CameraModel model, int width,
                                    int height, const Intrinsics& k) {
  std::vector<double> parameters = {k.fx, k.fy, k.cx, k.cy};
  parameters.insert(parameters.end(), k.distortion.begin(), k.distortion.end());
  parameters.resize(static_cast<size_t>(camera::CameraParameterCount(model)));
  return camera::Camera::Create(model, width, height, parameters.data(),
                                static_cast<int>(parameters.size()));
}

absl::StatusOr<camera::CameraModel> ModelOf(const std::string& name,
                                            const std::vector<double>& d) {
  const size_t used = static_cast<size_t>(
      d.rend() - std::ranges::find_if(d.rbegin(), d.rend(),
                                      [](double v) { return v != 0; }));
  if (name == "equidistant" && d.size() >= 4) {
    return camera::CameraModel::kOpenCvFisheye;
  }
  if (used == 0 && name != "equidistant") return camera::CameraModel::kPinhole;
  if (name == "plumb_bob" && used <= 4) return camera::CameraModel::kOpenCv;
  if ((name == "plumb_bob" || name == "rational_polynomial") && used <= 8) {
    return camera::CameraModel::kFullOpenCv;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "camera_info: the distortion model \"", name, "\" with ", d.size(),
      " coefficients is not known; rectify the "
      "pictures and say so, or use plumb_bob"));
}

// A length in pixels of the sensor, where `bin` of them became one, beginning
// with pixel `offset`.
double Binned(double position_px, uint32_t offset, uint32_t bin) {
  return (position_px - offset + 0.5) / bin - 0.5;
}

}  // namespace

absl::StatusOr<camera::Camera> CameraOf(const messages::CameraInfo& info,
                                        bool is_rectified) {
  Intrinsics k;
  if (is_rectified) {
    k = {info.p[0], info.p[5], info.p[2], info.p[6], {}};
  } else {
    k = {info.k[0], info.k[4], info.k[2], info.k[5], info.d};
  }
  if (!(k.fx > 0) || !(k.fy > 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "camera_info of ", info.header.frame_id, ": ", is_rectified ? "p" : "k",
        " has no focal length; calibrate the camera "
        "(camera_calibration) or give its driver the file"));
  }
  const uint32_t bin_x = std::max(info.binning_x, 1U);
  const uint32_t bin_y = std::max(info.binning_y, 1U);
  const messages::RegionOfInterest& roi = info.roi;
  const uint32_t width = roi.width > 0 ? roi.width : info.width;
  const uint32_t height = roi.height > 0 ? roi.height : info.height;
  k.cx = Binned(k.cx, roi.x_offset, bin_x);
  k.cy = Binned(k.cy, roi.y_offset, bin_y);
  k.fx /= bin_x;
  k.fy /= bin_y;
  TL_ASSIGN_OR_RETURN(const camera::CameraModel model,
                      is_rectified ? camera::CameraModel::kPinhole
                                   : ModelOf(info.distortion_model, info.d));
  return Made(model, static_cast<int>(std::min(width / bin_x, 1U << 20)),
              static_cast<int>(std::min(height / bin_y, 1U << 20)), k);
}

absl::StatusOr<messages::CameraInfo> InfoOf(const camera::Camera& camera,
                                            const messages::Header& header) {
  using camera::CameraModel;
  messages::CameraInfo info;
  info.header = header;
  info.width = static_cast<uint32_t>(camera.width());
  info.height = static_cast<uint32_t>(camera.height());
  info.k = {camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {camera.fx(), 0, camera.cx(), 0, 0, camera.fy(),
            camera.cy(), 0, 0,           0, 1, 0};
  info.distortion_model = "plumb_bob";
  const auto& p = camera.parameters();
  switch (camera.model()) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
      info.d = {0, 0, 0, 0, 0};
      return info;
    case CameraModel::kSimpleRadial:
      info.d = {p[3], 0, 0, 0, 0};
      return info;
    case CameraModel::kRadial:
      info.d = {p[3], p[4], 0, 0, 0};
      return info;
    case CameraModel::kOpenCv:
      info.d = {p[4], p[5], p[6], p[7], 0};
      return info;
    case CameraModel::kFullOpenCv:
      info.distortion_model = "rational_polynomial";
      info.d.assign(p.begin() + 4, p.begin() + 12);
      return info;
    case CameraModel::kOpenCvFisheye:
      info.distortion_model = "equidistant";
      info.d.assign(p.begin() + 4, p.begin() + 8);
      return info;
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("camera_info: no model of distortion is like ",
                       camera::CameraModelName(camera.model())));
  }
}

namespace {

// Black, and as large.
image::ColorImage PictureAs(const messages::Image& image) {
  image::ColorImage made = {.width = static_cast<int>(image.width),
                            .height = static_cast<int>(image.height),
                            .rgb = {}};
  made.rgb.resize(size_t{3} * image.width * image.height);
  return made;
}

absl::StatusOr<image::ColorImage> ColorOfYuv(const messages::Image& image,
                                             const YuvLayout& layout) {
  TL_RETURN_IF_ERROR(CheckRows(image, 2));
  if (image.width % 2 != 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "picture: ", image.encoding, " of an odd width, ", image.width));
  }
  image::ColorImage made = PictureAs(image);
  uint8_t* to = made.rgb.data();
  for (size_t y = 0; y < image.height; ++y) {
    const uint8_t* from = image.data.data() + y * image.step;
    for (size_t x = 0; x < image.width; x += 2, from += 4, to += 6) {
      WriteRgb(from[layout.y], from[layout.u], from[layout.v], to);
      WriteRgb(from[layout.y + 2], from[layout.u], from[layout.v], to + 3);
    }
  }
  return made;
}

}  // namespace

absl::StatusOr<image::ColorImage> ColorOf(const messages::Image& image) {
  const auto yuv = std::ranges::find_if(kYuvLayouts, [&](const auto& known) {
    return image.encoding == known.encoding;
  });
  if (yuv != kYuvLayouts.end()) return ColorOfYuv(image, *yuv);
  const auto layout = std::ranges::find_if(kLayouts, [&](const Layout& known) {
    return image.encoding == known.encoding;
  });
  if (layout == kLayouts.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("picture: the encoding \"", image.encoding,
                     "\" is not known; rgb8, bgr8, rgba8, bgra8, mono8, "
                     "yuv422 and yuv422_yuy2 are. image_proc makes colours of "
                     "Bayer patterns; or take /compressed"));
  }
  TL_RETURN_IF_ERROR(CheckRows(image, layout->bytes));
  image::ColorImage made = PictureAs(image);
  uint8_t* to = made.rgb.data();
  for (size_t y = 0; y < image.height; ++y) {
    const uint8_t* from = image.data.data() + y * image.step;
    if (layout->bytes == 3 && layout->red == 0) {
      std::memcpy(to, from, size_t{3} * image.width);
      to += size_t{3} * image.width;
      continue;
    }
    for (size_t x = 0; x < image.width; ++x, from += layout->bytes, to += 3) {
      to[0] = from[layout->red];
      to[1] = from[layout->green];
      to[2] = from[layout->blue];
    }
  }
  return made;
}

absl::StatusOr<image::ColorImage> ColorOf(
    const messages::CompressedImage& image) {
  return image::DecodeColor(TextOf(image.data), kLimits);
}

absl::StatusOr<image::DepthImage> DepthOf(const messages::Image& image) {
  const bool is_float = image.encoding == "32FC1";
  if (!is_float && image.encoding != "16UC1" && image.encoding != "mono16") {
    return absl::InvalidArgumentError(
        absl::StrCat("depth: the encoding \"", image.encoding,
                     "\" is not known; 16UC1, mono16 and 32FC1 are"));
  }
  const size_t pixel_bytes = is_float ? 4 : 2;
  TL_RETURN_IF_ERROR(CheckRows(image, pixel_bytes));
  const bool is_swapped =
      (image.is_bigendian != 0) != (std::endian::native == std::endian::big);
  image::DepthImage made = {.width = static_cast<int>(image.width),
                            .height = static_cast<int>(image.height),
                            .values = {},
                            .unit_m = kMillimetre};
  made.values.resize(size_t{image.width} * image.height);
  auto to = made.values.begin();
  for (size_t y = 0; y < image.height; ++y) {
    const uint8_t* from = image.data.data() + y * image.step;
    for (size_t x = 0; x < image.width; ++x, from += pixel_bytes, ++to) {
      *to = is_float ? image::MillimetresOf(ValueAt<float>(from, is_swapped))
                     : ValueAt<uint16_t>(from, is_swapped);
    }
  }
  return made;
}

absl::StatusOr<image::DepthImage> DepthOf(
    const messages::CompressedImage& image) {
  const bool is_float = absl::StrContains(image.format, "32FC1");
  const absl::string_view bytes = TextOf(image.data);
  // The transport "compressed" puts nothing in front.
  if (!is_float && image::SniffFormat(bytes) == image::ImageFormat::kPng) {
    return image::DecodeDepthPng(bytes, kMillimetre, kLimits);
  }
  if ((!is_float && !absl::StrContains(image.format, "16UC1")) ||
      image.data.size() < kCompressedDepthHeader) {
    return absl::InvalidArgumentError(absl::StrCat(
        "depth: the format \"", image.format, "\" of ", image.data.size(),
        " bytes is not known; \"16UC1; compressedDepth\" and \"32FC1; "
        "compressedDepth\", each with png or rvl, are"));
  }
  const absl::string_view packed = bytes.substr(kCompressedDepthHeader);
  const bool is_rvl = absl::StrContains(image.format, "rvl");
  TL_ASSIGN_OR_RETURN(
      image::DepthImage made,
      is_rvl ? image::DecodeRvl(packed, kMillimetre, kLimits)
             : image::DecodeDepthPng(packed, kMillimetre, kLimits));
  if (!is_float) return made;
  // Behind an int: the inverse of the depth was quantized,
  // value = a / depth + b (compressed_depth_image_transport, codec.cpp).
  const auto a = ValueAt<float>(image.data.data() + 4, false);
  const auto b = ValueAt<float>(image.data.data() + 8, false);
  for (uint16_t& value : made.values) {
    if (value != 0)
      value = image::MillimetresOf(a / (static_cast<float>(value) - b));
  }
  return made;
}

}  // namespace treeline::conversions

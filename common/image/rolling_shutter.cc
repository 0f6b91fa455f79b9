#include "common/image/rolling_shutter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace treeline::image {
namespace {

// The warp is as smooth as rotations and lenses are, and interpolated between
// places so many pixels apart.
constexpr int kCell_px = 16;
// Which row sees a place depends on where the row is: found step by step.
constexpr int kRowSteps = 3;
// In longer sides: no pixel is read there.
constexpr double kFarOutside = 8;

// Where to look in the picture as it is.
struct Source {
  float x = 0;
  float y = 0;
  // Distance along the optical axis there, for 1 here.
  float z = 1;
};

// The sources of all pixels of a picture.
class Warp {
 public:
  // `turn_rate_rad_s` about the camera's own axes; the middle row is seen
  // `offset_s` after the moment that is wanted.
  Warp(const camera::Camera& camera, geometry::Vec3 turn_rate_rad_s,
       double readout_s, double offset_s)
      : columns_((camera.width() + kCell_px - 1) / kCell_px + 1) {
    const int rows = (camera.height() + kCell_px - 1) / kCell_px + 1;
    nodes_.reserve(static_cast<size_t>(columns_) * static_cast<size_t>(rows));
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns_; ++column) {
        nodes_.push_back(
            SourceOf(camera, turn_rate_rad_s, readout_s, offset_s,
                     {1.0 * column * kCell_px, 1.0 * row * kCell_px}));
      }
    }
  }

  Source At(int x, int y) const {
    const size_t i =
        static_cast<size_t>(y / kCell_px) * static_cast<size_t>(columns_) +
        static_cast<size_t>(x / kCell_px);
    const size_t below = i + static_cast<size_t>(columns_);
    const float u = static_cast<float>(x % kCell_px) / kCell_px;
    const float v = static_cast<float>(y % kCell_px) / kCell_px;
    return Between(Between(nodes_[i], nodes_[i + 1], u),
                   Between(nodes_[below], nodes_[below + 1], u), v);
  }

 private:
  static Source Between(const Source& a, const Source& b, float t) {
    return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y),
            a.z + t * (b.z - a.z)};
  }

  static Source SourceOf(const camera::Camera& camera,
                         geometry::Vec3 turn_rate_rad_s, double readout_s,
                         double offset_s, camera::Pixel pixel) {
    const std::optional<camera::Pixel> ray = camera.Unproject(pixel);
    Source source{static_cast<float>(pixel.x), static_cast<float>(pixel.y), 1};
    if (!ray) return source;
    camera::Pixel seen = pixel;
    for (int i = 0; i < kRowSteps; ++i) {
      const double delay_s =
          offset_s + readout_s * RowShare(seen.y, camera.height());
      const geometry::Vec3 point =
          geometry::Rotation3::FromAxisAngle(-delay_s * turn_rate_rad_s) *
          geometry::Vec3{ray->x, ray->y, 1};
      if (!(point.z > 0)) return source;
      seen = camera.Project(point);
      source.z = static_cast<float>(point.z);
    }
    // Lenses that distort much send rays beyond the picture anywhere.
    const double far = kFarOutside * std::max(camera.width(), camera.height());
    if (!(std::abs(seen.x) < far && std::abs(seen.y) < far)) {
      return {static_cast<float>(pixel.x), static_cast<float>(pixel.y), 1};
    }
    source.x = static_cast<float>(seen.x);
    source.y = static_cast<float>(seen.y);
    return source;
  }

  int columns_;
  std::vector<Source> nodes_;
};

ColorImage Warped(const ColorImage& image, const Warp& warp) {
  ColorImage warped{image.width, image.height, {}};
  warped.rgb.resize(image.rgb.size());
  uint8_t* to = warped.rgb.data();
  const float last_x = static_cast<float>(image.width - 1);
  const float last_y = static_cast<float>(image.height - 1);
  const size_t stride = 3 * static_cast<size_t>(image.width);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Source source = warp.At(x, y);
      const float sx = std::clamp(source.x, 0.0F, last_x);
      const float sy = std::clamp(source.y, 0.0F, last_y);
      const int left = std::min(static_cast<int>(sx), image.width - 2);
      const int top = std::min(static_cast<int>(sy), image.height - 2);
      const float u = sx - static_cast<float>(left);
      const float v = sy - static_cast<float>(top);
      const uint8_t* from = image.rgb.data() +
                            static_cast<size_t>(top) * stride +
                            3 * static_cast<size_t>(left);
      for (size_t c = 0; c < 3; ++c) {
        const float above =
            from[c] + u * static_cast<float>(from[c + 3] - from[c]);
        const float below =
            from[c + stride] +
            u * static_cast<float>(from[c + stride + 3] - from[c + stride]);
        *to++ = static_cast<uint8_t>(above + v * (below - above) + 0.5F);
      }
    }
  }
  return warped;
}

// The nearest pixel's: depth is not interpolated over its jumps.
DepthImage Warped(const DepthImage& depth, const Warp& warp) {
  DepthImage warped{depth.width, depth.height, {}, depth.unit_m};
  warped.values.reserve(depth.values.size());
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const Source source = warp.At(x, y);
      const int from_x = static_cast<int>(std::lround(source.x));
      const int from_y = static_cast<int>(std::lround(source.y));
      uint16_t value = 0;
      if (from_x >= 0 && from_y >= 0 && from_x < depth.width &&
          from_y < depth.height) {
        value = depth.values[static_cast<size_t>(from_y) *
                                 static_cast<size_t>(depth.width) +
                             static_cast<size_t>(from_x)];
      }
      const float here = IsMeasured(value) ? value / source.z : 0;
      warped.values.push_back(
          here < 65534.5F ? static_cast<uint16_t>(here + 0.5F) : uint16_t{0});
    }
  }
  return warped;
}

}  // namespace

geometry::Vec3 TurnRateOf(camera::RgbdSensor sensor,
                          const camera::RgbdCalibration& calibration,
                          const FrameMotion& motion) {
  if (sensor == calibration.pose_sensor) return motion.turn_rate_rad_s;
  const geometry::Rotation3& color_from_depth =
      calibration.color_from_depth.rotation;
  return sensor == camera::RgbdSensor::kColor
             ? color_from_depth * motion.turn_rate_rad_s
             : color_from_depth.Inverse() * motion.turn_rate_rad_s;
}

Frame AtTimeStamp(const Frame& frame,
                  const camera::RgbdCalibration& calibration,
                  const RollingShutter& shutter, const FrameMotion& motion) {
  Frame result;
  result.calibration = frame.calibration;
  result.is_camera_assumed = frame.is_camera_assumed;
  result.orientation = frame.orientation;
  // Nothing to interpolate between.
  if (frame.color.width < 2 || frame.color.height < 2) return frame;
  result.color =
      Warped(frame.color,
             Warp(calibration.color,
                  TurnRateOf(camera::RgbdSensor::kColor, calibration, motion),
                  shutter.readout_s, shutter.offset_s));
  if (frame.depth) {
    result.depth = Warped(
        *frame.depth,
        Warp(calibration.depth,
             TurnRateOf(camera::RgbdSensor::kDepth, calibration, motion),
             shutter.readout_s, shutter.offset_s + motion.depth_delay_s));
  }
  return result;
}

}  // namespace treeline::image

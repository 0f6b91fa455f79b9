#include "server/core/features/rgbd_samples.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/core/features/parameters.h"
#include "server/core/features/pixel_difference.h"
#include "server/core/features/walsh_hadamard.h"

namespace treeline::features {
void RgbdSamples::clear() {
  x.clear();
  y.clear();
  inverse_depth_q12.clear();
  point.clear();
  depth_sigma_m.clear();
}

DepthGeometry::DepthGeometry(const camera::RgbdCalibration& calibration)
    : calibration_(calibration),
      color_from_depth_rotation_(
          calibration.color_from_depth.rotation.Matrix()) {}

bool DepthGeometry::Lift(int u, int v, double depth_m, Lifted& out) const {
  const std::optional<camera::Pixel> ray = calibration_.depth.Unproject(
      {static_cast<double>(u), static_cast<double>(v)});
  if (!ray) return false;
  const double z = calibration_.depth_scale * depth_m;
  const geometry::Vec3 point_in_depth{ray->x * z, ray->y * z, z};
  out.point_in_color = color_from_depth_rotation_ * point_in_depth +
                       calibration_.color_from_depth.translation;
  if (!(out.point_in_color.z > 0)) return false;
  out.point_in_pose_sensor =
      calibration_.pose_sensor == camera::RgbdSensor::kColor
          ? out.point_in_color
          : point_in_depth;
  out.color_pixel = calibration_.color.Project(out.point_in_color);
  return true;
}

double DepthSigma_m(double z_m) {
  return 0.0012 + 0.0019 * (z_m - 0.4) * (z_m - 0.4);
}

void DrawSamples(const DepthGeometry& geometry, const image::DepthImage& depth,
                 int count, base::Random random, RgbdSamples& samples) {
  DrawFirstSamples(geometry, depth, count, count, random, samples);
}

void DrawFirstSamples(const DepthGeometry& geometry,
                      const image::DepthImage& depth, int first, int count,
                      base::Random random, RgbdSamples& samples) {
  samples.clear();
  const camera::Camera& color = geometry.calibration().color;
  const uint32_t pixels = static_cast<uint32_t>(depth.values.size());
  const double focal_px = camera::MeanFocal_px(color);
  const size_t wanted = static_cast<size_t>(std::min(first, count));
  for (int draw = 0;
       draw < count * kMaxDrawsPerSample && samples.size() < wanted; ++draw) {
    const uint32_t i = random.NextBelow(pixels);
    if (!image::IsMeasured(depth.values[i])) continue;
    const double depth_m = depth.values[i] * depth.unit_m;
    if (depth_m < kMinDepth_m || depth_m > kMaxDepth_m) continue;
    DepthGeometry::Lifted lifted;
    if (!geometry.Lift(static_cast<int>(i) % depth.width,
                       static_cast<int>(i) / depth.width, depth_m, lifted)) {
      continue;
    }
    // Written so that NaN fails, and before any conversion to int.
    const camera::Pixel p = lifted.color_pixel;
    if (!(p.x > -0.5 && p.y > -0.5 && p.x < color.width() &&
          p.y < color.height())) {
      continue;
    }
    const int x = static_cast<int>(std::lround(p.x));
    const int y = static_cast<int>(std::lround(p.y));
    if (!PatchInside(x, y, color.width(), color.height())) continue;
    samples.x.push_back(x);
    samples.y.push_back(y);
    samples.inverse_depth_q12.push_back(
        InverseDepthQ12(focal_px, lifted.point_in_color.z));
    samples.point.push_back(lifted.point_in_pose_sensor);
    samples.depth_sigma_m.push_back(static_cast<float>(DepthSigma_m(depth_m)));
  }
}

void DrawPixels(const camera::Camera& color, int count, base::Random random,
                RgbdSamples& samples) {
  samples.clear();
  const int width = color.width() - 2 * kPatchRadius_px + 1;
  const int height = color.height() - 2 * kPatchRadius_px + 1;
  if (width < 1 || height < 1) return;
  for (int i = 0; i < count; ++i) {
    const int x =
        kPatchRadius_px +
        static_cast<int>(random.NextBelow(static_cast<uint32_t>(width)));
    const int y =
        kPatchRadius_px +
        static_cast<int>(random.NextBelow(static_cast<uint32_t>(height)));
    const std::optional<camera::Pixel> ray =
        color.Unproject({static_cast<double>(x), static_cast<double>(y)});
    if (!ray) continue;
    samples.x.push_back(x);
    samples.y.push_back(y);
    samples.inverse_depth_q12.push_back(
        NoDepthQ12(camera::MeanFocal_px(color)));
    samples.point.push_back({ray->x, ray->y, 1});
    samples.depth_sigma_m.push_back(0);
  }
}

}  // namespace treeline::features

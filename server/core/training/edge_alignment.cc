#include "server/core/training/edge_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace treeline::training {
namespace {

// A depth edge: the neighbour is further away by this share of the depth.
constexpr double kEdgeJump = 0.08;
// Far edges are blunt and few pixels wide.
constexpr double kMaxEdgeDepth_m = 4;

// One-dimensional Gaussian blur along rows or columns, borders repeated.
void BlurLines(std::vector<float>& image, int lines, int length,
               size_t line_stride, size_t step, double sigma_px) {
  const int radius = static_cast<int>(std::ceil(3 * sigma_px));
  std::vector<float> kernel(static_cast<size_t>(2 * radius + 1));
  float sum = 0;
  for (int k = -radius; k <= radius; ++k) {
    const float w =
        static_cast<float>(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
    kernel[static_cast<size_t>(k + radius)] = w;
    sum += w;
  }
  std::vector<float> line(static_cast<size_t>(length));
  for (int l = 0; l < lines; ++l) {
    float* data = image.data() + static_cast<size_t>(l) * line_stride;
    for (int i = 0; i < length; ++i) {
      line[static_cast<size_t>(i)] = data[static_cast<size_t>(i) * step];
    }
    for (int i = 0; i < length; ++i) {
      float value = 0;
      for (int k = -radius; k <= radius; ++k) {
        value += kernel[static_cast<size_t>(k + radius)] *
                 line[static_cast<size_t>(std::clamp(i + k, 0, length - 1))];
      }
      data[static_cast<size_t>(i) * step] = value / sum;
    }
  }
}

// Gradient magnitude of the grey image, capped, blurred, scaled to mean 1.
std::vector<float> EdgeStrength(const image::ColorImage& image,
                                double smoothing_px) {
  const int w = image.width;
  const int h = image.height;
  const size_t stride = static_cast<size_t>(w);
  std::vector<float> grey(stride * static_cast<size_t>(h));
  for (size_t i = 0; i < grey.size(); ++i) {
    grey[i] = 0.299f * image.rgb[3 * i] + 0.587f * image.rgb[3 * i + 1] +
              0.114f * image.rgb[3 * i + 2];
  }
  BlurLines(grey, h, w, stride, 1, 1.0);
  BlurLines(grey, w, h, 1, stride, 1.0);
  std::vector<float> strength(grey.size(), 0);
  for (int y = 1; y + 1 < h; ++y) {
    for (int x = 1; x + 1 < w; ++x) {
      const size_t i = static_cast<size_t>(y) * stride + static_cast<size_t>(x);
      const float dx = grey[i + 1] - grey[i - 1];
      const float dy = grey[i + stride] - grey[i - stride];
      // Texture as strong as an occlusion must not outvote it.
      strength[i] = std::min(30.0f, std::sqrt(dx * dx + dy * dy));
    }
  }
  BlurLines(strength, h, w, stride, 1, smoothing_px);
  BlurLines(strength, w, h, 1, stride, smoothing_px);
  double sum = 0;
  for (float s : strength) sum += static_cast<double>(s);
  const float scale =
      sum > 0 ? static_cast<float>(static_cast<double>(strength.size()) / sum)
              : 0.0f;
  for (float& s : strength) s *= scale;
  return strength;
}

}  // namespace

EdgeAlignment::EdgeAlignment(const std::vector<image::Frame>& frames,
                             double smoothing_px) {
  for (const image::Frame& frame : frames) {
    EdgeFrame edges;
    edges.width = frame.color.width;
    edges.height = frame.color.height;
    edges.strength = EdgeStrength(frame.color, smoothing_px);
    const image::DepthImage& depth = *frame.depth;
    const auto depth_m = [&](int u, int v) {
      const uint16_t value = depth.values[static_cast<size_t>(v) *
                                              static_cast<size_t>(depth.width) +
                                          static_cast<size_t>(u)];
      return image::IsMeasured(value) ? value * depth.unit_m : 0.0;
    };
    for (int v = 2; v + 2 < depth.height; ++v) {
      for (int u = 2; u + 2 < depth.width; ++u) {
        const double z = depth_m(u, v);
        if (z <= 0 || z > kMaxEdgeDepth_m) continue;
        constexpr std::array<std::array<int, 2>, 4> kNeighbours = {
            {{2, 0}, {-2, 0}, {0, 2}, {0, -2}}};
        for (const auto& d : kNeighbours) {
          if (depth_m(u + d[0], v + d[1]) <= z * (1 + kEdgeJump)) continue;
          // The edge runs between the two pixels.
          edges.edges.push_back(
              {static_cast<float>(u) + 0.5f * static_cast<float>(d[0]),
               static_cast<float>(v) + 0.5f * static_cast<float>(d[1]),
               static_cast<float>(z)});
          break;
        }
      }
    }
    frames_.push_back(std::move(edges));
  }
}

double EdgeAlignment::Strength(
    const camera::RgbdCalibration& calibration) const {
  double sum = 0;
  int64_t count = 0;
  for (const EdgeFrame& frame : frames_) {
    for (const EdgePixel& edge : frame.edges) {
      const auto ray = calibration.depth.Unproject({edge.u, edge.v});
      if (!ray) continue;
      const double z = calibration.depth_scale * edge.depth_m;
      const camera::Pixel p =
          calibration.color.Project(calibration.color_from_depth *
                                    geometry::Vec3{ray->x * z, ray->y * z, z});
      ++count;
      if (!(p.x >= 0 && p.y >= 0 && p.x < frame.width - 1 &&
            p.y < frame.height - 1)) {
        continue;
      }
      const int x = static_cast<int>(p.x);
      const int y = static_cast<int>(p.y);
      const double fx = p.x - x;
      const double fy = p.y - y;
      const float* s =
          frame.strength.data() +
          static_cast<size_t>(y) * static_cast<size_t>(frame.width) +
          static_cast<size_t>(x);
      sum += (1 - fy) * ((1 - fx) * s[0] + fx * s[1]) +
             fy * ((1 - fx) * s[frame.width] + fx * s[frame.width + 1]);
    }
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

}  // namespace treeline::training

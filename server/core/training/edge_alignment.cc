#include "server/core/training/edge_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/base/parallel_for.h"
#include "server/core/features/float_image.h"
#include "server/core/features/gaussian_blur.h"

namespace treeline::training {
namespace {

// A depth edge: the neighbour is further away by this share of the depth.
constexpr double kEdgeJump = 0.08;
// Far edges are blunt and few pixels wide.
constexpr double kMaxEdgeDepth_m = 4;

// So many edges are projected before the first of them is looked up: pictures
// of edges are larger than caches, and this hides the way to memory.
constexpr size_t kEdgesAtOnce = 32;

// Standard deviations at which blurs are cut off.
constexpr float kReach = 3;

features::FloatImage Blurred(const features::FloatImage& image,
                             double sigma_px) {
  features::FloatImage blurred;
  blurred.Resize(image.width(), image.height());
  std::vector<float> row;
  features::GaussianBlur(static_cast<float>(sigma_px), kReach)
      .Rows(image, 0, image.height(), blurred, row);
  return blurred;
}

// Gradient magnitude of the grey image, capped, blurred, scaled to mean 1.
std::vector<float> EdgeStrength(const image::ColorImage& image,
                                double smoothing_px) {
  features::FloatImage gray;
  std::vector<uint16_t> row_sums;
  features::ReduceToGray(image, 1, features::kLuma, row_sums, gray);
  gray = Blurred(gray, 1.0);
  const int w = image.width;
  const int h = image.height;
  features::FloatImage edges;
  edges.Resize(w, h);
  for (int y = 0; y < h; ++y) {
    float* out = edges.row(y);
    std::fill_n(out, w, 0.0F);
    if (y == 0 || y + 1 == h) continue;
    for (int x = 1; x + 1 < w; ++x) {
      const float dx = gray.row(y)[x + 1] - gray.row(y)[x - 1];
      const float dy = gray.row(y + 1)[x] - gray.row(y - 1)[x];
      // Texture as strong as an occlusion must not outvote it.
      out[x] = std::min(30.0f, std::sqrt(dx * dx + dy * dy));
    }
  }
  edges = Blurred(edges, smoothing_px);
  std::vector<float> strength;
  strength.reserve(static_cast<size_t>(w) * static_cast<size_t>(h));
  for (int y = 0; y < h; ++y) {
    strength.insert(strength.end(), edges.row(y), edges.row(y) + w);
  }
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
                             const camera::Camera& depth_camera,
                             double smoothing_px, int threads)
    : depth_camera_(depth_camera), threads_(threads), frames_(frames.size()) {
  base::ParallelFor(static_cast<int64_t>(frames.size()), threads,
                    [&](int64_t i) {
                      const size_t f = static_cast<size_t>(i);
                      frames_[f] = EdgesOf(frames[f], smoothing_px);
                    });
}

EdgeAlignment::EdgeFrame EdgeAlignment::EdgesOf(const image::Frame& frame,
                                                double smoothing_px) const {
  EdgeFrame edges;
  edges.width = frame.color.width;
  edges.height = frame.color.height;
  edges.strength = EdgeStrength(frame.color, smoothing_px);
  const image::DepthImage& depth = *frame.depth;
  const auto depth_m = [&](int u, int v) {
    const uint16_t value =
        depth.values[static_cast<size_t>(v) * static_cast<size_t>(depth.width) +
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
        const camera::Pixel edge = {u + 0.5 * d[0], v + 0.5 * d[1]};
        edges.edges.push_back(
            {edge, depth_camera_.Unproject(edge), static_cast<float>(z)});
        break;
      }
    }
  }
  return edges;
}

EdgeAlignment::Sum EdgeAlignment::StrengthIn(
    const EdgeFrame& frame, const camera::RgbdCalibration& calibration) const {
  struct Place {
    const float* strength;
    double fx;  // share of the next column, and row
    double fy;
  };
  std::array<Place, kEdgesAtOnce> places;
  const bool rays_are_known = calibration.depth == depth_camera_;
  Sum sum;
  for (size_t first = 0; first < frame.edges.size(); first += kEdgesAtOnce) {
    size_t count = 0;
    const size_t end = std::min(frame.edges.size(), first + kEdgesAtOnce);
    for (size_t i = first; i < end; ++i) {
      const EdgePixel& edge = frame.edges[i];
      const auto ray =
          rays_are_known ? edge.ray : calibration.depth.Unproject(edge.pixel);
      if (!ray) continue;
      const double z = calibration.depth_scale * edge.depth_m;
      const camera::Pixel p =
          calibration.color.Project(calibration.color_from_depth *
                                    geometry::Vec3{ray->x * z, ray->y * z, z});
      ++sum.edges;
      if (!(p.x >= 0 && p.y >= 0 && p.x < frame.width - 1 &&
            p.y < frame.height - 1)) {
        continue;
      }
      const int x = static_cast<int>(p.x);
      const int y = static_cast<int>(p.y);
      const float* at =
          frame.strength.data() +
          static_cast<size_t>(y) * static_cast<size_t>(frame.width) +
          static_cast<size_t>(x);
      __builtin_prefetch(at);
      __builtin_prefetch(at + frame.width);
      places[count++] = {at, p.x - x, p.y - y};
    }
    for (const auto& [s, fx, fy] : std::span(places).first(count)) {
      sum.strength +=
          (1 - fy) * ((1 - fx) * s[0] + fx * s[1]) +
          fy * ((1 - fx) * s[frame.width] + fx * s[frame.width + 1]);
    }
  }
  return sum;
}

double EdgeAlignment::Strength(
    const camera::RgbdCalibration& calibration) const {
  std::vector<Sum> sums(frames_.size());
  base::ParallelFor(static_cast<int64_t>(frames_.size()), threads_,
                    [&](int64_t i) {
                      const size_t f = static_cast<size_t>(i);
                      sums[f] = StrengthIn(frames_[f], calibration);
                    });
  // In the order of the frames, whichever thread was first.
  Sum all;
  for (const Sum& sum : sums) {
    all.strength += sum.strength;
    all.edges += sum.edges;
  }
  return all.edges == 0 ? 0 : all.strength / static_cast<double>(all.edges);
}

}  // namespace treeline::training

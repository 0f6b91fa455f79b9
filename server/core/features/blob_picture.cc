#include "server/core/features/blob_picture.h"

#include <algorithm>
#include <cmath>

#include "common/base/random.h"

namespace treeline::features {
namespace {

uint8_t ToByte(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

image::ColorImage PaintBlobs(const std::vector<Blob>& blobs, int width,
                             int height) {
  std::vector<double> sum(static_cast<size_t>(width * height), 100.0);
  for (const Blob& blob : blobs) {
    const int reach = static_cast<int>(std::ceil(5 * blob.sigma));
    const int left = std::max(0, static_cast<int>(blob.x) - reach);
    const int right = std::min(width - 1, static_cast<int>(blob.x) + reach);
    const int top = std::max(0, static_cast<int>(blob.y) - reach);
    const int bottom = std::min(height - 1, static_cast<int>(blob.y) + reach);
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        const double dx = (x - blob.x) / blob.sigma;
        const double dy = (y - blob.y) / blob.sigma;
        sum[static_cast<size_t>(y * width + x)] +=
            blob.height * std::exp(-0.5 * (dx * dx + dy * dy));
      }
    }
  }
  image::ColorImage image{width, height, {}};
  for (const double value : sum) {
    image.rgb.insert(image.rgb.end(), 3, ToByte(value));
  }
  return image;
}

std::vector<Blob> RandomBlobs(int count, int width, int height) {
  std::vector<Blob> blobs;
  base::Random random(3, 0);
  for (int i = 0; i < count; ++i) {
    blobs.push_back({random.NextUniform(10, width - 10),
                     random.NextUniform(10, height - 10),
                     random.NextUniform(1.5, 5), random.NextUniform(-90, 90)});
  }
  return blobs;
}

NearestFeature NearestTo(const Blob& blob, const SiftFeatures& features) {
  NearestFeature nearest;
  for (const SiftKeypoint& k : features.keypoints) {
    const double px = std::hypot(k.pixel.x - blob.x, k.pixel.y - blob.y);
    if (px < nearest.distance_px) {
      nearest = {.keypoint = &k, .distance_px = px};
    }
  }
  return nearest;
}

image::ColorImage ChangeValues(const image::ColorImage& image,
                               const std::function<double(double)>& change) {
  image::ColorImage changed = image;
  for (uint8_t& value : changed.rgb) value = ToByte(change(value));
  return changed;
}

}  // namespace treeline::features

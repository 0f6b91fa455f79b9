// Pictures for tests of features: blobs whose places and sizes are known.
#ifndef SERVER_CORE_FEATURES_BLOB_PICTURE_H_
#define SERVER_CORE_FEATURES_BLOB_PICTURE_H_

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "common/image/image.h"
#include "server/core/features/sift_features.h"

namespace treeline::features {

struct Blob {
  double x, y, sigma, height;
};

// Gaussians on a background of 100.
image::ColorImage PaintBlobs(const std::vector<Blob>& blobs, int width,
                             int height);

// `count` of them all over a picture of this size.
std::vector<Blob> RandomBlobs(int count, int width, int height);

// The feature that is nearest to a blob; of no features: none, infinitely far
// away.
struct NearestFeature {
  const SiftKeypoint* keypoint = nullptr;
  double distance_px = std::numeric_limits<double>::infinity();
};
NearestFeature NearestTo(const Blob& blob, const SiftFeatures& features);

// Every value changed, rounded and cut off at 0 and 255.
image::ColorImage ChangeValues(const image::ColorImage& image,
                               const std::function<double(double)>& change);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_BLOB_PICTURE_H_

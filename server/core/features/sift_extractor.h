// SIFT features of an image (Lowe 2004), as OpenCV computes them.
#ifndef SERVER_CORE_FEATURES_SIFT_EXTRACTOR_H_
#define SERVER_CORE_FEATURES_SIFT_EXTRACTOR_H_

#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/image/image.h"
#include "server/core/features/sift_features.h"

namespace treeline::features {

struct SiftOptions {
  // Features kept, those of the largest regions; 0: all. Small ones are many
  // and do not survive a change of distance.
  int max_features = 2500;
  // OpenCV's contrastThreshold (0.04 is its default), in (0, 1].
  double contrast = 0.02;
};

// The features of `image`, largest regions first. A place with several dominant
// gradient directions has a feature for each. Runs on the calling thread;
// OpenCV as a whole runs on one thread from the first call on. INTERNAL if
// OpenCV fails.
//
// Descriptors are RootSIFT (Arandjelovic and Zisserman 2012): divided by their
// sum, square roots taken, times 512, as bytes. Their Euclidean distance is
// Hellinger's distance of the histograms.
//
// OpenCV 4.6 gives positions that are a quarter of a pixel too large, because
// it doubles the image about pixel corners and halves positions about pixel
// centres. This is put right.
absl::StatusOr<SiftFeatures> ExtractSift(const image::ColorImage& image,
                                         const SiftOptions& options);

// The descriptors at given keypoints, in their order; responses mean nothing.
// A keypoint whose region leaves the image is described by what is inside. All
// zero for images of less than 8 pixels a side, which have no features either.
// INTERNAL if OpenCV fails.
absl::StatusOr<std::vector<SiftDescriptor>> DescribeSift(
    const image::ColorImage& image, std::span<const SiftKeypoint> keypoints);

// RootSIFT of 128 histogram values, none negative.
SiftDescriptor RootSift(std::span<const float> histogram);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SIFT_EXTRACTOR_H_

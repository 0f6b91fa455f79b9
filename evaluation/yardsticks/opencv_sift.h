// OpenCV's SIFT features, beside which ours are measured.
#ifndef EVALUATION_YARDSTICKS_OPENCV_SIFT_H_
#define EVALUATION_YARDSTICKS_OPENCV_SIFT_H_

#include "absl/status/statusor.h"
#include "common/image/image.h"
#include "server/core/features/sift_extractor.h"
#include "server/core/features/sift_features.h"

namespace treeline::yardsticks {

// What features::SiftExtractor finds, by OpenCV: contrast is its
// contrastThreshold. Runs on the calling thread; OpenCV as a whole runs on one
// thread from the first call on. INTERNAL if OpenCV fails.
//
// OpenCV 4.6 gives positions that are a quarter of a pixel too large, because
// it doubles the image about pixel corners and halves positions about pixel
// centres. This is put right.
absl::StatusOr<features::SiftFeatures> ExtractOpenCvSift(
    const image::ColorImage& image, const features::SiftOptions& options);

}  // namespace treeline::yardsticks

#endif  // EVALUATION_YARDSTICKS_OPENCV_SIFT_H_

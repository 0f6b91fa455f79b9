// SIFT features of an image (Lowe 2004), our own: lean, and the same in any
// light.
#ifndef SERVER_CORE_FEATURES_FAST_SIFT_H_
#define SERVER_CORE_FEATURES_FAST_SIFT_H_

#include <cstddef>
#include <vector>

#include "common/image/image.h"
#include "server/core/features/scale_space.h"
#include "server/core/features/scale_space_extrema.h"
#include "server/core/features/sift_features.h"

namespace treeline::features {

struct FastSiftOptions {
  // Features kept: strong ones, spread over the picture.
  int max_features = 450;
  // For cameras that are held upright: no angle is sought, all are 0. Such
  // features are more distinct, and are lost when the camera rolls.
  bool upright = false;
  // The picture is reduced by no less: features are sought no finer.
  int least_reduction = 1;
};

// Beside Lowe's features (SiftExtractor), which take ten times as long:
// * the picture is reduced first (ScaleSpace), not doubled;
// * nothing depends on the picture's gain or offset of brightness: thresholds
//   are relative to its own contrast, and features compete with their
//   neighbours;
// * a descriptor is of gradients on a grid that turns with the feature.
// Descriptors are RootSIFT in bytes as those of SiftExtractor, but of other
// regions: the two must not be matched with each other.
//
// Keeps its working memory from picture to picture: one object a thread. The
// same picture gives the same features, bit for bit, on machines with the same
// vector instructions.
class FastSift {
 public:
  // Those first that a shorter list would keep. None for pictures too small for
  // an octave.
  SiftFeatures Extract(const image::ColorImage& image,
                       const FastSiftOptions& options = {});

 private:
  void FindAllExtrema();
  void Rank(size_t count);

  ScaleSpace space_;
  std::vector<ScaleSpaceExtremum> extrema_;
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_FAST_SIFT_H_

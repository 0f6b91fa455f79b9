// SIFT features of an image (Lowe 2004): of the doubled image, as OpenCV finds
// them.
#ifndef SERVER_CORE_FEATURES_SIFT_EXTRACTOR_H_
#define SERVER_CORE_FEATURES_SIFT_EXTRACTOR_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/image.h"
#include "server/core/features/scale_space.h"
#include "server/core/features/scale_space_extrema.h"
#include "server/core/features/sift_features.h"

namespace treeline::features {

struct SiftOptions {
  // Features kept, those of the largest regions; 0: all. Small ones are many
  // and do not survive a change of distance.
  int max_features = 2500;
  // Least difference of blurs, as a share of the brightest white, times the
  // three layers of an octave; in (0, 1]. Lowe and OpenCV have 0.04.
  double contrast = 0.02;
};

// Finds features, largest regions first. A place with several dominant gradient
// directions has a feature for each, strongest first.
//
// Descriptors are RootSIFT (Arandjelovic and Zisserman 2012): divided by their
// sum, square roots taken, times 512, as bytes. Their Euclidean distance is
// Hellinger's distance of the histograms. They are alike enough to OpenCV's to
// be matched with them (docs/research/structure-from-motion.md).
//
// Features of an octave are larger than those of all finer ones. So octaves are
// looked at from the coarsest to the finest, that of the doubled image, until
// there are max_features: the result is the same as if all were.
//
// Keeps its working memory from picture to picture: one object a thread. The
// same picture gives the same features, bit for bit, on machines with the same
// vector instructions.
class SiftExtractor {
 public:
  SiftExtractor();

  // None for images of less than 8 pixels a side.
  SiftFeatures Extract(const image::ColorImage& image,
                       const SiftOptions& options);

  // The descriptors at given keypoints, in their order; responses mean nothing.
  // A keypoint whose region leaves the image is described as if the image went
  // on with its edge. All zero for images of less than 8 pixels a side.
  std::vector<SiftDescriptor> Describe(const image::ColorImage& image,
                                       std::span<const SiftKeypoint> keypoints);

 private:
  void AddOctave(ScaleSpace& space, size_t octave, const SiftOptions& options,
                 SiftFeatures& features);

  // The octaves of the image, which are as they would be if they came from the
  // doubled image: on its pixels, a quarter of a pixel further left and up.
  void BeginWhole(const image::ColorImage& image);
  // That of the doubled image, after BeginWhole.
  void BeginDoubled();

  FloatImage gray_;
  FloatImage moved_;  // gray_, shifted or doubled
  ScaleSpace whole_;
  ScaleSpace doubled_;
  std::vector<ScaleSpaceExtremum> extrema_;
  std::vector<uint16_t> row_sums_;
};

// With working memory of their own.
SiftFeatures ExtractSift(const image::ColorImage& image,
                         const SiftOptions& options);
std::vector<SiftDescriptor> DescribeSift(
    const image::ColorImage& image, std::span<const SiftKeypoint> keypoints);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SIFT_EXTRACTOR_H_

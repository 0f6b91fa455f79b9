// What a feature's surroundings look like: the directions in which brightness
// changes there (Lowe 2004, sections 5 and 6).
#ifndef SERVER_CORE_FEATURES_GRADIENT_HISTOGRAMS_H_
#define SERVER_CORE_FEATURES_GRADIENT_HISTOGRAMS_H_

#include <array>
#include <cstddef>

#include "server/core/features/float_image.h"
#include "server/core/features/sift_descriptor.h"

namespace treeline::features {

// A place in a raster. `sigma`, in its pixels, is the scale of what is there.
struct ImagePlace {
  float x = 0;
  float y = 0;
  float sigma = 0;
};

struct DominantAngles {
  static constexpr size_t kMax = 8;
  std::array<float, kMax> angle_rad{};
  size_t count = 0;
};

// The directions of most change around a place, as the angle from x towards y
// in [0, 2 pi), strongest first: peaks of the histogram of gradient directions,
// weighted by their size and by a Gaussian. None where brightness does not
// change.
//
// FastSift's, two at most: the histogram is held as its first Fourier
// coefficients, so that it is smooth and turns with the picture exactly.
DominantAngles FindDominantAngles(const FloatImage& image,
                                  const ImagePlace& place);

// Lowe's: of 36 directions, smoothed; those that have a peak of 0.8 of the
// highest. The Gaussian's standard deviation is 1.5 sigma, the window's radius
// 4.5 sigma, at most 24 pixels.
DominantAngles FindLoweAngles(const FloatImage& image, const ImagePlace& place);

// Lowe's 4 x 4 histograms of 8 directions, in the frame turned by angle_rad, as
// RootSIFT (see SiftExtractor); cells are cell_sigmas * sigma wide. The patch
// is sampled on a grid that turns and grows with the feature, so that the
// cells' weights are always the same. What lies outside the image looks like
// its edge. Does not depend on the gain and offset of the brightness.
SiftDescriptor DescribePlace(const FloatImage& image, const ImagePlace& place,
                             float angle_rad, float cell_sigmas);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_GRADIENT_HISTOGRAMS_H_

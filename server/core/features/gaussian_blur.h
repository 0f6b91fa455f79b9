// Pictures blurred by Gaussians.
#ifndef SERVER_CORE_FEATURES_GAUSSIAN_BLUR_H_
#define SERVER_CORE_FEATURES_GAUSSIAN_BLUR_H_

#include <vector>

#include "server/core/features/float_image.h"

namespace treeline::features {

// Beyond its edges a picture goes on with what is there.
class GaussianBlur {
 public:
  // The Gaussian is cut off at `reach` standard deviations, rounded to pixels,
  // but not before the next pixel.
  GaussianBlur(float sigma_px, float reach);

  // Rows that count, on either side of one.
  int radius() const { return static_cast<int>(taps_.size()) - 1; }

  // Rows [begin, end) of `in`, blurred, into `out`, another picture of the same
  // size. `row` is working memory.
  void Rows(const FloatImage& in, int begin, int end, FloatImage& out,
            std::vector<float>& row) const;

 private:
  // From the middle on; they sum to one over both sides.
  std::vector<float> taps_;
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_GAUSSIAN_BLUR_H_

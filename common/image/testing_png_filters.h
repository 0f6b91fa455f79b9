// For tests: what the PNG standard says of filters.
#ifndef COMMON_IMAGE_TESTING_PNG_FILTERS_H_
#define COMMON_IMAGE_TESTING_PNG_FILTERS_H_

#include <cstdlib>

namespace treeline::image {

// The standard's table of filters, byte by byte.
inline int Predicted(int filter, int left, int above, int diagonal) {
  const int p = left + above - diagonal;
  const int pa = std::abs(p - left);
  const int pb = std::abs(p - above);
  const int pc = std::abs(p - diagonal);
  const int paeth = pa <= pb && pa <= pc ? left : (pb <= pc ? above : diagonal);
  const int predictions[] = {0, left, above, (left + above) / 2, paeth};
  return predictions[filter];
}

}  // namespace treeline::image

#endif  // COMMON_IMAGE_TESTING_PNG_FILTERS_H_

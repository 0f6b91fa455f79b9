// What a depth image says of many points at once, in single precision.
#ifndef SERVER_CORE_KEYFRAMES_DEPTH_LOOKUP_H_
#define SERVER_CORE_KEYFRAMES_DEPTH_LOOKUP_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"
#include "server/core/keyframes/alignment_kernels.h"

namespace treeline::keyframes {

// A depth image beside the colour camera, of a pinhole or with OpenCV's
// rational distortion.
struct DepthView {
  std::array<float, 9> depth_from_color_rotation;  // row by row
  std::array<float, 3> depth_from_color_translation;
  std::array<float, 9> color_from_depth_rotation;
  std::array<float, 3> color_from_depth_translation;
  float fx, fy, cx, cy;  // px
  float k1, k2, k3, k4, k5, k6, p1, p2;
  float unit;  // of the world, in a unit of the image
  int width;
  int height;
  const uint16_t* values;
};

// nullopt for other lenses. The image must outlive it.
std::optional<DepthView> DepthViewOf(const camera::RgbdCalibration& calibration,
                                     const image::DepthImage& depth);

// What was measured where points are seen, in the same slots: in the colour
// camera (m), and the standard deviation of its depth; 0: nothing.
struct MeasuredPoints {
  std::vector<float> x, y, z, sigma_m;

  void resize(size_t points);
};

// Looks up the points [begin, end), multiples of kAlignmentBlock, that are
// seen.
void MeasureDepth(const VisiblePoints& seen, size_t begin, size_t end,
                  const DepthView& view, MeasuredPoints& measured);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_DEPTH_LOOKUP_H_

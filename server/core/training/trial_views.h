// Frames as a scene may be asked about: covered, blurred, in another light; and
// as no camera can see it.
#ifndef SERVER_CORE_TRAINING_TRIAL_VIEWS_H_
#define SERVER_CORE_TRAINING_TRIAL_VIEWS_H_

#include <array>

#include "common/image/frame.h"

namespace treeline::training {

// A window given as shares of an image's size.
struct Window {
  double left, top, right, bottom;
  bool Contains(double x, double y) const {
    return x >= left && x < right && y >= top && y < bottom;
  }
};

// What becomes of a channel's brightness v in [0, 1]: gain * v^gamma.
struct Light {
  std::array<double, 3> gain{1, 1, 1};  // of red, green and blue
  double gamma = 1;
  bool is_gray = false;
};

bool HaveSameSizes(const image::Frame& a, const image::Frame& b);

// As a mirror shows it, depth as well: no camera in the scene can see that.
image::Frame Mirrored(const image::Frame& frame);

// `cover` but for a window of `frame`. Both have the same sizes.
image::Frame Covered(const image::Frame& frame, const image::Frame& cover,
                     const Window& window);

// Smeared sideways by so many pixels to either side, as by a moving camera.
image::Frame Blurred(const image::Frame& frame, int radius_px);

// In another light. Depth stays.
image::Frame Relit(const image::Frame& frame, const Light& light);

image::Frame WithoutDepth(const image::Frame& frame);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_TRIAL_VIEWS_H_

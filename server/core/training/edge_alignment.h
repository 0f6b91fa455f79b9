// Does colour change where depth jumps? The photometric half of calibration.
#ifndef SERVER_CORE_TRAINING_EDGE_ALIGNMENT_H_
#define SERVER_CORE_TRAINING_EDGE_ALIGNMENT_H_

#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"

namespace treeline::training {

// Depth edges and colour edge strength of some frames.
class EdgeAlignment {
 public:
  // smoothing_px: standard deviation of the blur of the edge strength. More
  // sees further and less sharply. Frame::depth must be present.
  EdgeAlignment(const std::vector<image::Frame>& frames, double smoothing_px);

  // Mean colour edge strength, normalised per image to mean 1, at the depth
  // edges as `calibration` projects them; larger is better.
  double Strength(const camera::RgbdCalibration& calibration) const;

 private:
  // A pixel on the near side of a depth edge: what occludes is sharp in both
  // images.
  struct EdgePixel {
    float u = 0;
    float v = 0;
    float depth_m = 0;
  };
  struct EdgeFrame {
    std::vector<EdgePixel> edges;
    int width = 0;
    int height = 0;
    std::vector<float> strength;  // of the colour image, row-major
  };
  std::vector<EdgeFrame> frames_;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_EDGE_ALIGNMENT_H_

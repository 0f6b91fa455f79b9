// Does colour change where depth jumps? The photometric half of calibration.
#ifndef SERVER_CORE_TRAINING_EDGE_ALIGNMENT_H_
#define SERVER_CORE_TRAINING_EDGE_ALIGNMENT_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"

namespace treeline::training {

// Depth edges and colour edge strength of some frames.
class EdgeAlignment {
 public:
  // smoothing_px: standard deviation of the blur of the edge strength. More
  // sees further and less sharply. Frame::depth must be present. Calibrations
  // with this depth camera are compared fastest: undistorting pixels is what
  // costs most.
  EdgeAlignment(const std::vector<image::Frame>& frames,
                const camera::Camera& depth_camera, double smoothing_px,
                int threads);

  // Mean colour edge strength, normalised per image to mean 1, at the depth
  // edges as `calibration` projects them; larger is better.
  double Strength(const camera::RgbdCalibration& calibration) const;

 private:
  // A pixel on the near side of a depth edge: what occludes is sharp in both
  // images.
  struct EdgePixel {
    camera::Pixel pixel;
    std::optional<camera::Pixel> ray;  // through depth_camera_
    float depth_m = 0;
  };
  struct EdgeFrame {
    std::vector<EdgePixel> edges;
    int width = 0;
    int height = 0;
    std::vector<float> strength;  // of the colour image, row-major
  };
  EdgeFrame EdgesOf(const image::Frame& frame, double smoothing_px) const;
  // Sum over the edges that have a ray, and their number.
  struct Sum {
    double strength = 0;
    int64_t edges = 0;
  };
  Sum StrengthIn(const EdgeFrame& frame,
                 const camera::RgbdCalibration& calibration) const;

  const camera::Camera depth_camera_;
  const int threads_;
  std::vector<EdgeFrame> frames_;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_EDGE_ALIGNMENT_H_
